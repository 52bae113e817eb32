"""The contract: schemes that keep it pass every check, and one that breaks a promise fails the right one."""

import importlib.util
from pathlib import Path

import pytest

from wm3d.attacks import ATTACKS
from wm3d.contract import ATTACK_CHECKS, SCHEME_CHECKS, examine
from wm3d.schemes import SCHEMES

_spec = importlib.util.spec_from_file_location("broken", Path(__file__).parent / "broken.py")
broken = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(broken)


def faults(component, checks):
    return {outcome.check: outcome.fault for outcome in examine(component, checks) if outcome.fault}


@pytest.mark.parametrize("name", SCHEMES)
def test_every_scheme_keeps_the_contract(name):
    assert faults(SCHEMES.build(name, {}), SCHEME_CHECKS) == {}


def test_the_good_samples_keep_the_contract():
    assert faults(broken.Harmless(), ATTACK_CHECKS) == {}
    assert faults(broken.Paper(), SCHEME_CHECKS) == {}


@pytest.mark.parametrize("name", ["gaussian-noise", "crop"])
def test_an_attack_set_to_change_nothing_need_not_be_random(name):
    assert faults(ATTACKS.build(name, {"percent": 0}), ATTACK_CHECKS) == {}


@pytest.mark.parametrize("cls", broken.ATTACKS, ids=lambda cls: cls.__name__)
def test_broken_attack_fails_the_check_of_what_it_breaks(cls):
    check, words = broken.ATTACKS[cls]
    assert words in faults(cls(), ATTACK_CHECKS).get(check, "passed")


@pytest.mark.parametrize("cls", broken.SCHEMES, ids=lambda cls: cls.__name__)
def test_broken_scheme_fails_the_check_of_what_it_breaks(cls):
    check, words = broken.SCHEMES[cls]
    assert words in faults(cls(), SCHEME_CHECKS).get(check, "passed")


def test_every_check_is_failed_by_some_broken_sample():
    failed = {check for table in (broken.ATTACKS, broken.SCHEMES) for check, _ in table.values()}
    named = {check.__name__.replace("_", "-") for check in (*ATTACK_CHECKS, *SCHEME_CHECKS)}
    untried = {name for name in named - failed if not name.startswith(("open-mesh", "inward-wound-mesh"))}
    assert untried == set()
