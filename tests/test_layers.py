"""The layers of the package import only downwards."""

import subprocess
import sys
from pathlib import Path


def test_layers_import_only_downwards():
    root = Path(__file__).parents[1]
    check = "from importlinter.cli import lint_imports_command; lint_imports_command()"
    result = subprocess.run(
        [sys.executable, "-c", check, "--no-cache"], cwd=root, capture_output=True, text=True, check=False
    )
    assert "layers import only downwards KEPT" in result.stdout, result.stdout + result.stderr
    assert result.returncode == 0
