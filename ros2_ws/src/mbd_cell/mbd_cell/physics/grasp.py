"""How the cell's hand holds things, and the contact physics that takes."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class Grasp(StrEnum):
    """What keeps an object in the hand.

    FRICTION: nothing but the fingers' pressure and friction; objects slip, tip and fall. WELD: the object is fixed to
    the hand as soon as two opposed fingers touch it, which is fast and never fails: for tests of everything else.
    """

    WELD = "weld"
    FRICTION = "friction"


@dataclass(frozen=True)
class ContactSettings:
    """How contacts are computed.

    Attributes:
        timestep: [s], a whole part of a control tick.
        noslip_iterations: of the solver that takes the creep out of soft frictional contacts.
        impratio: [-] how much stiffer friction is than the normal force of a contact.
        object_friction: sliding [-], torsional [m], rolling [m] coefficients between object and object or table.
        pad_friction: alike, between the fingers' rubber and anything.
    """

    timestep: float
    noslip_iterations: int
    impratio: float
    object_friction: tuple[float, float, float]
    pad_friction: tuple[float, float, float]


CONTACTS = {
    Grasp.WELD: ContactSettings(0.002, 0, 10.0, (0.9, 0.01, 0.001), (0.9, 0.01, 0.001)),
    # Glazed and moulded things on wood, and rubber on either. Without noslip a grasp creeps by millimetres a minute; at
    # an impratio of 10 a bowl held by its rim turned by 5 to 9 degrees in the hand on its way, at 100 by 1 or 2.
    Grasp.FRICTION: ContactSettings(0.001, 4, 100.0, (0.5, 0.003, 0.0002), (0.9, 0.005, 0.0002)),
}
