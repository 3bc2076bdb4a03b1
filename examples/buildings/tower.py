"""Building B: a tower, 20 x 20 m and 60 m high, turned by 17 degrees, with a round stair beside it."""

from __future__ import annotations

import math

import numpy as np

from buildings.facet_model import Frame, Model, Plate, make_rectangle

SIDE, HEIGHT = 20.0, 54.0
TURN = math.radians(17.0)


def build_tower() -> Model:
    """Build a tower with a curtain wall, a passage through it, and a round stair before it."""
    model = Model()
    add_body(model)
    add_stair(model, center=(-4.2, 6.0), steps_a_turn=16, turns=4)
    model.finish()
    cos, sin = math.cos(TURN), math.sin(TURN)
    model.points = [np.array([cos * x - sin * y, sin * x + cos * y, z]) for x, y, z in model.points]
    return model


def add_body(model: Model) -> None:
    """Add the body: four walls, the roof with its parapet, the ground face."""
    walls = []
    for origin, right in (
        ((0, 0, 0), (1, 0, 0)),
        ((SIDE, 0, 0), (0, 1, 0)),
        ((SIDE, SIDE, 0), (-1, 0, 0)),
        ((0, SIDE, 0), (0, -1, 0)),
    ):
        walls.append(model.add_plate(Frame.span(origin, right, (0, 0, 1)), make_rectangle(0, 0, SIDE, HEIGHT)))
    front, east, back, west = walls
    for wall in (front, east, west):
        add_curtain(wall)
    for storey in range(11):
        for left in (3.0, 9.4, 15.8):
            back.recess(make_rectangle(left, 9.6 + 3.75 * storey, left + 1.2, 11.6 + 3.75 * storey), 0.3)
    for wall in (east, west):
        for left in (2.0, 7.5, 13.0):
            wall.recess(make_rectangle(left, 0.8, left + 5.0, 6.2), 0.5)
    add_passage(model, front, back)
    add_crown(model)
    model.add([(0, SIDE, 0), (SIDE, SIDE, 0), (SIDE, 0, 0), (0, 0, 0)])


def add_curtain(wall: Plate) -> None:
    """Add five bays of tall panes, and fins on the mullions between them."""
    bay, storey, mullion = 3.7, 5.3, 0.26
    left, bottom = (SIDE - 5 * bay) / 2, 9.4
    for column in range(5):
        for row in range(8):
            start, low = left + bay * column + mullion / 2, bottom + storey * row + mullion
            wall.recess(make_rectangle(start, low, start + bay - mullion, low + storey - 2 * mullion), 0.25)
    for column in range(6):
        middle = left + bay * column
        wall.recess(make_rectangle(middle - 0.06, bottom - 0.6, middle + 0.06, bottom + 8 * storey + 0.6), -0.4)


def add_passage(model: Model, front: Plate, back: Plate) -> None:
    """Add a vaulted passage through the tower, its floor a step above the ground."""
    middle, floor, spring, radius, facets = SIDE / 2, 0.4, 4.4, 2.8, 12
    arch = [(middle - radius, floor), (middle + radius, floor)]
    for k in range(facets + 1):
        angle = math.pi * k / facets
        arch.append((middle + radius * math.cos(angle), spring + radius * math.sin(angle)))
    front.open((x, 0.0, z) for x, z in arch)
    back.open((x, SIDE, z) for x, z in arch[::-1])
    for (x, z), (x2, z2) in zip(arch, arch[1:] + arch[:1], strict=True):
        model.add([(x, 0, z), (x2, 0, z2), (x2, SIDE, z2), (x, SIDE, z)])


def add_crown(model: Model) -> None:
    """Add a roof behind a parapet, with a machine room and a mast."""
    rim = model.add_plate(Frame.span((0, 0, HEIGHT), (1, 0, 0), (0, 1, 0)), make_rectangle(0, 0, SIDE, SIDE))
    roof = rim.recess(make_rectangle(0.5, 0.5, SIDE - 0.5, SIDE - 0.5), 1.1)
    room = roof.recess(make_rectangle(5.0, 9.0, 15.0, 16.0), -4.1)
    angles = [k * math.pi / 4 for k in range(8)]
    room.recess([(7 + 0.4 * math.cos(angle), 12 + 0.4 * math.sin(angle)) for angle in angles], -3)
    for left in (9.5, 12.2):
        room.recess(make_rectangle(left, 10.5, left + 2.0, 14.5), -0.8)
    roof.recess(make_rectangle(3.0, 2.5, 6.5, 6.0), -1.6)


def add_stair(model: Model, center: tuple[float, float], steps_a_turn: int, turns: int) -> None:
    """Add steps winding round a column: a closed solid of its own beside the tower."""
    inner, outer, rise, thick = 0.5, 2.6, 0.25, 0.4
    steps, top = steps_a_turn * turns, rise * (steps_a_turn * turns + 5)

    def at(radius: float, step: int, z: float) -> tuple[float, float, float]:
        angle = 2 * math.pi * (step % steps_a_turn) / steps_a_turn
        return center[0] + radius * math.cos(angle), center[1] + radius * math.sin(angle), z

    for k in range(steps):
        low, high = rise * (k + 1), rise * (k + 1) + thick
        model.add([at(inner, k, high), at(outer, k, high), at(outer, k + 1, high), at(inner, k + 1, high)])
        model.add([at(inner, k, low), at(inner, k + 1, low), at(outer, k + 1, low), at(outer, k, low)])
        model.add([at(outer, k, low), at(outer, k + 1, low), at(outer, k + 1, high), at(outer, k, high)])
        # Towards the step before: the riser shows above it; at the foot of the stair all of the side does.
        riser = high - rise if k else low
        model.add([at(inner, k, riser), at(outer, k, riser), at(outer, k, high), at(inner, k, high)])
        # Towards the step after: its underside stands out below that one's.
        shown = low + rise if k + 1 < steps else high
        ahead = k + 1
        model.add([at(inner, ahead, low), at(inner, ahead, shown), at(outer, ahead, shown), at(outer, ahead, low)])
    for sector in range(steps_a_turn):
        lows = [rise * (k + 1) for k in range(sector, steps, steps_a_turn)]
        heights = [0.0, *(z for low in lows for z in (low, low + thick)), top]
        for low, high in zip(heights[::2], heights[1::2], strict=True):
            left, right = sector, sector + 1
            model.add([at(inner, left, low), at(inner, right, low), at(inner, right, high), at(inner, left, high)])
    column = range(steps_a_turn)
    model.add([at(inner, k, top) for k in column])
    model.add([at(inner, k, 0.0) for k in reversed(column)])
