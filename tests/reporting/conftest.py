"""What the figure tests share; made once."""

import figure_data
import pytest

from modallab.reporting.content import ReportContent
from modallab.reporting.report import render


@pytest.fixture(scope="session")
def content() -> ReportContent:
    return figure_data.content()


@pytest.fixture(scope="session")
def page(content: ReportContent) -> str:
    return render(content)
