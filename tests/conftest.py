"""Options of the whole test suite."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from pathlib import Path

import pytest

# A suite that is started in the background inherits an ignored Ctrl-C, and so does every process it starts; the
# tests that press Ctrl-C would wait for nothing.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--shared",
        type=Path,
        metavar="FOLDER",
        help="folder with the third-party files that tests/validation/third_party compares with; without it "
        "they are deselected",
    )
    parser.addoption(
        "--long", action="store_true", help="also tests that take minutes each; without it they are deselected"
    )


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """What runs only when asked for: comparisons with third-party files, which are not ours to ship, and long tests."""
    if config.getoption("--shared") is None:
        third_party = [item for item in items if item.path.parent.name == "third_party"]
        config.hook.pytest_deselected(items=third_party)
        items[:] = [item for item in items if item not in third_party]
    if not config.getoption("--long"):
        long = [item for item in items if item.get_closest_marker("long")]
        config.hook.pytest_deselected(items=long)
        items[:] = [item for item in items if item not in long]


ROOT = Path(__file__).parents[1]


@pytest.fixture(autouse=True)
def no_stray_file() -> Iterator[None]:
    """What a test writes goes into a folder of its own; the checkout, from which the suite is started, stays as it is."""
    before = set(ROOT.iterdir())
    yield
    stray = {path.name for path in set(ROOT.iterdir()) - before if not path.name.startswith(".")}
    assert stray - {"build"} == set(), "left in the checkout; write below tmp_path"


@pytest.fixture(scope="session")
def shared(request: pytest.FixtureRequest) -> Path:
    """The folder named by --shared."""
    return request.config.getoption("--shared")
