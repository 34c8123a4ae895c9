"""What stands where according to a State, by exhaustive search: every sphere of every tool against every leg of every string, every line and
every sphere of every body. Truth of its own: it reads scenes and tree files itself and knows nothing of how the daemon looks for contacts."""
import pathlib
import struct

import numpy

MODELS = pathlib.Path(__file__).resolve().parents[2] / "deploy" / "models"
SLIGHT_SAG_M = 2.25e-3


def leaves(name):
    """Centres and radii (n x 4) of a tree file: mark, version, four counts, hash of the source, two bounds, the root, levels, name, leaves."""
    data = (MODELS / name).read_bytes()
    count, _, levels, length = struct.unpack_from("<4I", data, 12)
    offset = 12 + 16 + 32 + 2 * 8 + 4 * 8 + 20 * levels + length
    return numpy.frombuffer(data, "<f8", 4 * count, offset).reshape(count, 4)


def blend_of(shape):
    """Width over which the leaves of a body blend, m: the last number of a tree file of the second version."""
    if shape.WhichOneof("contact") != "tree":
        return 0.0
    data = (MODELS / shape.tree).read_bytes()
    return struct.unpack_from("<d", data, len(data) - 40)[0] if struct.unpack_from("<I", data, 8) == (2,) else 0.0


def blended(distances, width):
    """phi of each row: sum (1 - (d - phi) / w)^3 over what is positive is 1; by halving."""
    high = distances.min(axis=1)
    low = high - width
    for _ in range(50):
        middle = (low + high) / 2
        many = ((1 - (distances - middle[:, None]) / width).clip(0) ** 3).sum(axis=1) > 1
        low, high = numpy.where(many, low, middle), numpy.where(many, middle, high)
    return low


def turn(q):
    """Rotation matrix of w, x, y, z, which need not be quite unit."""
    w, x, y, z = numpy.asarray(q, float) / numpy.linalg.norm(q)
    return numpy.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])


def placed(spheres, p, q):
    return numpy.column_stack([spheres[:, :3] @ turn(q).T + numpy.asarray(p, float), spheres[:, 3]])


def pose(message):
    return (list(message.p_m) or [0, 0, 0], list(message.q) or [1, 0, 0, 0])


def spheres_of(shape):
    if shape.WhichOneof("contact") == "tree":
        return leaves(shape.tree)
    given = shape.spheres
    return numpy.column_stack([numpy.array(given.centre_m).reshape(-1, 3), numpy.array(given.radius_m)])


def distance_to_axis(points, a, b):
    """Of many points to a segment."""
    axis = b - a
    square = axis @ axis
    share = numpy.clip((points - a) @ axis / square, 0, 1) if square > 0 else numpy.zeros(len(points))
    return numpy.linalg.norm(points - a - share[:, None] * axis, axis=1)


class Stage:
    """A scene as SceneInfo tells it, and how the solver looks at it."""

    def __init__(self, scene, solver):
        self.margin, self.skin = solver.margin_m, solver.skin_m
        self.tools = {tool.tool_id: numpy.vstack([placed(spheres_of(part.shape), *pose(part.pose_gp)) for part in tool.parts])
                      for tool in scene.tools}
        self.strings = [(numpy.array(each.p_wa_m), numpy.array(each.p_wb_m), each.radius_m, each.sag_m) for each in scene.strings]
        self.lines = [(numpy.array(each.points_w_m).reshape(-1, 3), each.radius_m) for each in scene.lines]
        self.bodies = [(placed(spheres_of(each.shape), *pose(each.pose_wb)), blend_of(each.shape)) for each in scene.bodies]

    def tool(self, told):
        return placed(self.tools[told.tool_id], told.p_wg_m, told.q_wg)

    def rest(self, string, share):
        """A place on the axis at rest: a cable is a parabola of straight pieces."""
        a, b, _, sag = self.strings[string]
        pieces = 1 if sag == 0 else 3 if sag <= SLIGHT_SAG_M else 5
        k = min(int(share * pieces), pieces - 1)
        ends = [a + s * (b - a) - numpy.array([0, 4 * sag * s * (1 - s), 0]) for s in (k / pieces, (k + 1) / pieces)]
        return ends[0] + (share * pieces - k) * (ends[1] - ends[0])

    def axis(self, string, told=None):
        """Corners of the string's axis as drawn; told: its StringState."""
        sag = self.strings[string][3]
        pieces = 1 if sag == 0 else 3 if sag <= SLIGHT_SAG_M else 5
        corners = {k / pieces: numpy.zeros(3) for k in range(pieces + 1)}
        if told is not None:
            vertices = [(getattr(told, "lambda"), told.deflection_w_m)]
            further = told.further_deflection_w_m
            vertices += [(share, further[3 * k:3 * k + 3]) for k, share in enumerate(told.further_lambda)]
            vertices.sort(key=lambda vertex: vertex[0])
            bent = [(share, numpy.array(u)) for share, u in vertices]
            ends = [(0.0, numpy.zeros(3))] + bent + [(1.0, numpy.zeros(3))]
            shares = [share for share, _ in ends]
            # Between two vertices the deflection goes evenly; so it does at the knots of a cable.
            for share in corners:
                corners[share] = numpy.array([numpy.interp(share, shares, [u[axis] for _, u in ends]) for axis in range(3)])
            corners.update({share: u for share, u in bent})
        return [self.rest(string, share) + corners[share] for share in sorted(corners)]

    def gap_to_string(self, string, told, points, radii):
        """The smallest gap of spheres to a string as drawn, or, without a StringState, at rest."""
        corners = self.axis(string, told)
        return min((distance_to_axis(points, a, b) - radii).min() for a, b in zip(corners, corners[1:])) - self.strings[string][2]

    def gap_to_line(self, number, points, radii):
        corners, r = self.lines[number]
        return min((distance_to_axis(points, a, b) - radii).min() for a, b in zip(corners, corners[1:])) - r

    def gap_to_body(self, number, points, radii, room):
        """The smallest gap to a body's spheres; of those that are not within `room`, none."""
        body, width = self.bodies[number]
        low, high = (points - radii[:, None]).min(axis=0), (points + radii[:, None]).max(axis=0)
        reach = body[:, 3:4] + room + width
        near = body[numpy.all((body[:, :3] + reach >= low) & (body[:, :3] - reach <= high), axis=1)]
        if width > 0 and len(near):
            off = numpy.linalg.norm(points[:, None, :] - near[None, :, :3], axis=2) - near[None, :, 3]
            rows = off.min(axis=1) - radii < room + width
            return (blended(off[rows], width) - radii[rows]).min() if rows.any() else numpy.inf
        nearest = numpy.inf
        for first in range(0, len(near), 256):
            some = near[first:first + 256]
            between = numpy.linalg.norm(points[:, None, :] - some[None, :, :3], axis=2) - radii[:, None] - some[None, :, 3]
            nearest = min(nearest, between.min())
        return nearest

    def gap_to_object(self, patch, state):
        """The smallest gap between the tool and the object of a ContactPatch."""
        spheres = self.tool(next(tool for tool in state.tools if tool.tool_id == patch.tool_id))
        points, radii = spheres[:, :3], spheres[:, 3]
        kind = patch.WhichOneof("object")
        number = getattr(patch, kind)
        if kind == "line_index":
            return self.gap_to_line(number, points, radii)
        if kind == "body_index":
            return self.gap_to_body(number, points, radii, 0.02)
        told = {each.string_index: each for each in state.strings}
        return self.gap_to_string(number, told.get(number), points, radii)

    def gaps(self, state):
        """Of each tool (by id): the smallest gap to strings and lines, and to everything."""
        told = {each.string_index: each for each in state.strings}
        out = {}
        for tool in state.tools:
            spheres = self.tool(tool)
            points, radii = spheres[:, :3], spheres[:, 3]
            nearest = numpy.inf
            for number in range(len(self.strings)):
                nearest = min(nearest, self.gap_to_string(number, told.get(number), points, radii))
            for number in range(len(self.lines)):
                nearest = min(nearest, self.gap_to_line(number, points, radii))
            drawn = nearest
            for number in range(len(self.bodies)):
                nearest = min(nearest, self.gap_to_body(number, points, radii, max(min(nearest, 0.02), 0)))
            out[tool.tool_id] = (drawn, nearest)
        return out
