"""Building A: a gabled house, 12 x 9 m, its ridge at 7.3 m; the origin is a corner of its ground face."""

from __future__ import annotations

from itertools import pairwise

from buildings.facet_model import Frame, Model, Plate, make_rectangle

LENGTH, DEPTH, WALL = 12.0, 9.0, 3.4
PITCH = 0.8
SLAB = 0.3
EAVE, VERGE = 0.5, 0.4


def find_roof_height(y: float) -> float:
    """Return the height of the upper side of the roof."""
    return WALL + SLAB + PITCH * min(y, DEPTH - y)


def build_house() -> Model:
    """Build a gabled house with dormers, recessed windows and a chimney."""
    model = Model()
    add_walls(model)
    front, back = add_roof(model)
    for left in (1.9, 8.1):
        add_dormer(model, front, left, 2.0)
    add_shed_dormer(model, back)
    add_chimney(model, back)
    return model.finish()


def add_walls(model: Model) -> None:
    """Add four walls with their windows and doors, the front steps, and the ground face."""
    steps = (5.0, 7.0)
    front = model.add_plate(
        Frame.span((0, 0, 0), (1, 0, 0), (0, 0, 1)),
        [
            (0, 0),
            (steps[0], 0),
            (steps[0], 0.3),
            (steps[1], 0.3),
            (steps[1], 0),
            (12, 0),
            (12, WALL),
            (0, WALL),
        ],
    )
    door = front.recess(make_rectangle(5.4, 0.36, 6.6, 2.5), 0.2)
    for low, high in ((0.55, 1.1), (1.25, 1.95)):
        for left in (5.52, 6.06):
            door.recess(make_rectangle(left, low, left + 0.42, high), 0.03)
    for left in (1.5, 8.8):
        add_window(front, left, 1.0, 1.7, 1.35, panes=3)
        add_shutters(front, left, 1.0, 1.7, 1.35)
    back = model.add_plate(Frame.span((12, 9, 0), (-1, 0, 0), (0, 0, 1)), make_rectangle(0, 0, 12, WALL))
    for left in (1.0, 3.3, 9.4):
        add_window(back, left, 1.0, 1.4, 1.35)
    back.recess(make_rectangle(5.6, 0.1, 8.4, 2.4), 0.16).recess(make_rectangle(5.7, 0.2, 8.3, 2.3), 0.04)
    gable = [(0, 0), (9, 0), (9, WALL), (4.5, WALL + 4.5 * PITCH), (0, WALL)]
    for frame in (
        Frame.span((0, 9, 0), (0, -1, 0), (0, 0, 1)),
        Frame.span((12, 0, 0), (0, 1, 0), (0, 0, 1)),
    ):
        wall = model.add_plate(frame, gable)
        for left in (1.3, 6.1):
            add_window(wall, left, 1.0, 1.6, 1.35)
        add_window(wall, 3.7, 4.2, 1.6, 1.3)
    add_steps(model, *steps)


def add_steps(model: Model, left: float, right: float) -> None:
    """Add two steps up to the front door, and the ground face that they share with the house."""
    profile = [(0.0, 0.3), (-0.5, 0.3), (-0.5, 0.15), (-1.0, 0.15), (-1.0, 0.0)]
    for (y, z), (y2, z2) in pairwise(profile):
        model.add([(left, y, z), (left, y2, z2), (right, y2, z2), (right, y, z)])
    side = [(0.0, 0.0), *profile]
    model.add([(left, y, z) for y, z in side[::-1]])
    model.add([(right, y, z) for y, z in side])
    ground = [(0, 0), (left, 0), (left, -1), (right, -1), (right, 0), (12, 0), (12, 9), (0, 9)]
    model.add([(x, y, 0) for x, y in ground[::-1]])


def add_roof(model: Model) -> tuple[Plate, Plate]:
    """Add a roof slab that stands out over all walls; returns its front and back slope."""
    west, east = -VERGE, LENGTH + VERGE
    front_y, back_y, ridge = -EAVE, DEPTH + EAVE, DEPTH / 2

    def under(y: float) -> float:
        return find_roof_height(y) - SLAB

    slopes = []
    slope = (ridge - front_y) * (1 + PITCH * PITCH) ** 0.5
    for origin, along, across in (
        ((west, front_y, find_roof_height(front_y)), (1, 0, 0), (0, 1, PITCH)),
        ((east, back_y, find_roof_height(back_y)), (-1, 0, 0), (0, -1, PITCH)),
    ):
        frame = Frame.span(origin, along, across)
        slopes.append(model.add_plate(frame, make_rectangle(0, 0, east - west, slope)))
    for y, wall_y, start, end in ((front_y, 0.0, west, east), (back_y, DEPTH, east, west)):
        inner = (0.0, LENGTH) if start < end else (LENGTH, 0.0)
        model.add(
            [(start, y, under(y)), (end, y, under(y)), (end, y, find_roof_height(y)), (start, y, find_roof_height(y))]
        )
        soffit = [(start, y), (start, ridge), (inner[0], ridge), (inner[0], wall_y)]
        soffit += [(inner[1], wall_y), (inner[1], ridge), (end, ridge), (end, y)]
        model.add([(x, at, under(at)) for x, at in soffit])
    chevron = [(y, find_roof_height(y)) for y in (front_y, ridge, back_y)]
    chevron += [(y, under(y)) for y in (back_y, ridge, front_y)]
    model.add([(west, y, z) for y, z in chevron])
    model.add([(east, y, z) for y, z in chevron[::-1]])
    return slopes[0], slopes[1]


def add_dormer(model: Model, slope: Plate, left: float, width: float) -> None:
    """Add a gabled dormer on the front slope."""
    right, middle = left + width, left + width / 2
    face, eave, top = 0.6, 5.4, 6.3
    sill = find_roof_height(face)
    eave_end, top_end = ((z - WALL - SLAB) / PITCH for z in (eave, top))
    slope.open(
        (x, y, find_roof_height(y))
        for x, y in ((left, face), (right, face), (right, eave_end), (middle, top_end), (left, eave_end))
    )
    wall = model.add_plate(
        Frame.span((left, face, sill), (1, 0, 0), (0, 0, 1)),
        [(0, 0), (width, 0), (width, eave - sill), (width / 2, top - sill), (0, eave - sill)],
    )
    add_window(wall, width / 2 - 0.6, 0.3, 1.2, 1.1)
    model.add([(left, face, sill), (left, face, eave), (left, eave_end, eave)])
    model.add([(right, face, sill), (right, eave_end, eave), (right, face, eave)])
    model.add([(left, face, eave), (middle, face, top), (middle, top_end, top), (left, eave_end, eave)])
    model.add([(right, face, eave), (right, eave_end, eave), (middle, top_end, top), (middle, face, top)])


def add_shed_dormer(model: Model, slope: Plate) -> None:
    """Add a wide dormer with a flat-pitched roof on the back slope."""
    west, east, face, pitch = 3.5, 8.5, 0.7, 0.2
    sill, eave = find_roof_height(face), 5.8
    end = (eave - pitch * face - WALL - SLAB) / (PITCH - pitch)
    top = find_roof_height(end)
    slope.open([(x, DEPTH - y, find_roof_height(y)) for x, y in ((east, face), (west, face), (west, end), (east, end))])
    wall = model.add_plate(
        Frame.span((east, DEPTH - face, sill), (-1, 0, 0), (0, 0, 1)),
        make_rectangle(0, 0, east - west, eave - sill),
    )
    for left in (0.5, 2.0, 3.5):
        add_window(wall, left, 0.3, 1.0, 1.0)
    y, y_end = DEPTH - face, DEPTH - end
    model.add([(east, y, sill), (east, y, eave), (east, y_end, top)])
    model.add([(west, y, sill), (west, y_end, top), (west, y, eave)])
    model.add([(east, y, eave), (west, y, eave), (west, y_end, top), (east, y_end, top)])


def add_chimney(model: Model, slope: Plate) -> None:
    """Add a shaft near the ridge with a wider cap and two flues."""
    west, east, south, north, neck, top = 9.7, 10.9, 5.0, 5.7, 7.9, 8.2
    ring = [(west, south), (east, south), (east, north), (west, north)]
    slope.open((x, y, find_roof_height(y)) for x, y in ring)
    for (x, y), (x2, y2) in zip(ring, ring[1:] + ring[:1], strict=True):
        model.add([(x, y, find_roof_height(y)), (x2, y2, find_roof_height(y2)), (x2, y2, neck), (x, y, neck)])
    out = 0.12
    cap = make_rectangle(west - out, south - out, east + out, north + out)
    model.add([(x, y, neck) for x, y in cap[::-1]], [[(x, y, neck) for x, y in ring]])
    for (x, y), (x2, y2) in zip(cap, cap[1:] + cap[:1], strict=True):
        model.add([(x, y, neck), (x2, y2, neck), (x2, y2, top), (x, y, top)])
    lid = model.add_plate(Frame.span((0, 0, top), (1, 0, 0), (0, 1, 0)), cap)
    for left in (west + 0.12, east - 0.52):
        lid.recess(make_rectangle(left, south + 0.15, left + 0.4, north - 0.15), 0.25)


def add_window(plate: Plate, left: float, bottom: float, width: float, height: float, panes: int = 2) -> None:
    """Recess a window with two rows of panes, and a sill below it."""
    frame = plate.recess(make_rectangle(left, bottom, left + width, bottom + height), 0.16)
    bar = 0.07
    across = (width - bar) / panes
    for k in range(panes):
        for low, high in ((bar, 0.62 * height - bar), (0.62 * height, height - bar)):
            start = left + bar + k * across
            pane = make_rectangle(start, bottom + low, start + across - bar, bottom + high)
            frame.recess(pane, 0.03)
    plate.recess(make_rectangle(left - 0.1, bottom - 0.15, left + width + 0.1, bottom - 0.05), -0.09)


def add_shutters(plate: Plate, left: float, bottom: float, width: float, height: float) -> None:
    """Hang a shutter on either side of a window."""
    for start in (left - 0.62, left + width + 0.12):
        plate.recess(make_rectangle(start, bottom, start + 0.5, bottom + height), -0.05)
