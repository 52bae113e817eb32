"""The experiment harness: config, plan, run, store, tables, figures."""
