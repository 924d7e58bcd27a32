"""How camera, hand and board hang together, and by how much a picture disagrees.

X is camera2base (board on the hand) or camera2tool (board on the table), Y is board2tool or board2base. For a picture i
with the tool at T and the board before the camera at P:

    on the hand    T^-1 X P Y^-1 = 1        on the table    X P Y^-1 T = 1

up to the error of the tool's pose, which the left sides are, written in the tool's frame, and up to the picture's.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from mbd_robot.calibration.board.views import FINEST, BoardView, view_of
from mbd_robot.calibration.errors import CalibrationError
from mbd_robot.calibration.pairs.pair import BoardMounting, CalibrationPair, PairSet
from mbd_robot.calibration.solving.hand_eye import Array
from mbd_robot.calibration.transforms import Transforms, adjoint, inverse, logarithm, mean_transform


@dataclass(frozen=True)
class HandEyeProblem:
    """Pictures with their poses, ready to be solved.

    Attributes:
        given: where it comes from.
        pairs: those of ``given`` with a pose of the board.
        views: of each pair.
        pixel_noise: [px] standard deviation of a corner's u or v, from how corners fit the board's plane.
    """

    given: PairSet
    pairs: tuple[CalibrationPair, ...]
    views: tuple[BoardView, ...]
    pixel_noise: float

    @property
    def names(self) -> list[str]:
        """Of the pictures."""
        return [pair.name for pair in self.pairs]

    @cached_property
    def tools(self) -> Transforms:
        """(n, 4, 4) tool2base."""
        return np.stack([pair.tool for pair in self.pairs])

    @cached_property
    def board(self) -> Transforms:
        """(n, 4, 4) board2camera, P."""
        return np.stack([view.pose for view in self.views])

    @cached_property
    def arm(self) -> Transforms:
        """(n, 4, 4) for which arm @ X @ board is Y: base2tool, or tool2base with the camera on the hand."""
        return inverse(self.tools) if self.given.mounting is BoardMounting.HAND else self.tools

    @cached_property
    def picture_noise(self) -> Array:
        """(n, 6, 6) covariance of the twist of P in the board's frame."""
        return np.stack([view.shape for view in self.views]) * self.pixel_noise**2

    def subset(self, chosen: NDArray[np.bool_] | NDArray[np.int64]) -> HandEyeProblem:
        """The pictures of these indices or of this mask."""
        numbers = np.arange(len(self.pairs))[chosen]
        return replace(
            self, pairs=tuple(self.pairs[i] for i in numbers), views=tuple(self.views[i] for i in numbers)
        )  # fmt: skip

    def board_pose(self, x: Transforms) -> Transforms:
        """(4, 4) Y for an X: in the middle of what the pictures say."""
        return mean_transform(self.arm @ x @ self.board)

    def boards_in_tool(self, y: Transforms) -> Transforms:
        """(n, 4, 4) board2tool."""
        if self.given.mounting is BoardMounting.HAND:
            return np.broadcast_to(y, (len(self.pairs), 4, 4))
        return inverse(self.tools) @ y

    def disagreement(self, x: Transforms, y: Transforms) -> Array:
        """(n, 6) twists [rad, m], in the tool's frame, by which each picture and its pose disagree."""
        if self.given.mounting is BoardMounting.HAND:
            return logarithm(inverse(self.tools) @ x @ self.board @ inverse(y))
        return logarithm(x @ self.board @ inverse(y) @ self.tools)

    def slopes(self, x: Transforms, y: Transforms) -> Array:
        """(n, 6, 12) of ``disagreement`` by the twists of X (in the camera's frame) and of Y (in the board's).

        By the tools' poses, not the pictures': where all tools are turned alike, noise of the pictures must not pass
        for different turns.
        """
        hand = self.given.mounting is BoardMounting.HAND
        cameras = inverse(self.tools) @ x if hand else np.broadcast_to(x, (len(self.pairs), 4, 4))
        return np.concatenate((adjoint(cameras), -adjoint(self.boards_in_tool(y))), axis=2)

    def noise(self, y: Transforms, turn: float, place: float) -> Array:
        """(n, 6, 6) covariance of ``disagreement``.

        Args:
            y: Y.
            turn: [rad] standard deviation of the tool's turn about an axis.
            place: [m] of its place along an axis.
        """
        frames = adjoint(self.boards_in_tool(y))
        arm = np.diag([turn**2] * 3 + [place**2] * 3)
        return frames @ self.picture_noise @ np.swapaxes(frames, 1, 2) + arm

    def settled(self, x: Transforms, y: Transforms) -> HandEyeProblem:
        """With that pose of a flat board, of the two that its picture nearly allows, which agrees better."""
        views = []
        for i, view in enumerate(self.views):
            if view.other is not None:
                rival = replace(view, pose=view.other, other=view.pose)
                one = self.subset(np.array([i]))
                here = np.linalg.norm(one.disagreement(x, y)[0, :3])
                there = np.linalg.norm(replace(one, views=(rival,)).disagreement(x, y)[0, :3])
                views.append(rival if there < here else view)
            else:
                views.append(view)
        return replace(self, views=tuple(views))


def problem_of(given: PairSet) -> HandEyeProblem:
    """The pictures in which the board has a pose; raises CalibrationError when there are fewer than four."""
    pairs, views = [], []
    for pair in given.pairs:
        view = view_of(pair.corners, given.board, given.lens)
        if view is not None:
            pairs.append(pair)
            views.append(view)
    if len(pairs) < 4:
        unseen = f"; it was not found in {', '.join(given.blind[:8])}" if given.blind else ""
        raise CalibrationError(
            f"the board is seen in {len(pairs)} pictures{unseen}; expected at least 4, better 12 to 20, with the tool "
            "turned differently in each; does --board say what was printed?"
        )
    squares, freedom = sum(v.squares for v in views), sum(v.freedom for v in views)
    return HandEyeProblem(given, tuple(pairs), tuple(views), max(float(np.sqrt(squares / freedom)), FINEST))
