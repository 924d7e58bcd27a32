"""What the generated classes of services and actions are made of; there is no such module at run time."""

from typing import Generic, TypeVar

RequestT = TypeVar("RequestT")
ResponseT = TypeVar("ResponseT")
GoalT = TypeVar("GoalT")
ResultT = TypeVar("ResultT")
FeedbackT = TypeVar("FeedbackT")

class Service(Generic[RequestT, ResponseT]): ...
class Action(Generic[GoalT, ResultT, FeedbackT]): ...
