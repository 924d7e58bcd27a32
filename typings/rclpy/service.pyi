from typing import Generic, TypeVar

RequestT = TypeVar("RequestT")
ResponseT = TypeVar("ResponseT")

class Service(Generic[RequestT, ResponseT]):
    @property
    def service_name(self) -> str: ...
    def destroy(self) -> None: ...
