"""Options of the whole test suite."""

from __future__ import annotations

from pathlib import Path

import pytest


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--shared",
        type=Path,
        metavar="FOLDER",
        help="folder with the third-party files that tests/validation/third_party compares with; without it "
        "they are deselected",
    )


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """The third-party files are not ours to ship: comparisons with them run only where a folder is named."""
    if config.getoption("--shared") is None:
        third_party = [item for item in items if item.path.parent.name == "third_party"]
        config.hook.pytest_deselected(items=third_party)
        items[:] = [item for item in items if item not in third_party]


@pytest.fixture(scope="session")
def shared(request: pytest.FixtureRequest) -> Path:
    """The folder named by --shared."""
    return request.config.getoption("--shared")
