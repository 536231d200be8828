"""What the service rejected, as an exception."""

import httpx
from pydantic import ValidationError

from modallab.core.documents.pages import Problem


class ServiceProblemError(Exception):
    """The service answered with a problem; `problem` says which, and what to do."""

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        super().__init__(problem)

    def __str__(self) -> str:
        said = f"{self.problem.title}: {self.problem.detail}"
        return f"{said}\n  what to do: {self.problem.remedy}" if self.problem.remedy else said


def require_good(response: httpx.Response) -> httpx.Response:
    """The response, if it is no problem.

    Raises:
        ServiceProblemError: it is.
    """
    if response.is_success:
        return response
    try:
        raise ServiceProblemError(Problem.model_validate_json(response.content))
    except ValidationError as error:
        # Not from the service itself, but from something in between.
        text = f"status {response.status_code} from {response.request.url}"
        unknown = Problem(type="", title="No answer of the service", status=response.status_code, code="", detail=text)
        raise ServiceProblemError(unknown) from error
