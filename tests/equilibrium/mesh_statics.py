"""The exact statics of a tool of spheres that does not turn on the mesh of a body, and what a slide on the body's tree feels beside it: its
ripple. SI.

The tool goes where it is next to the hand with no point of the mesh nearer than its radius; the force is kt times the way. Planes
through the points of the mesh that are nearest cut off where the centre may not be; each is exact where the mesh bulges, and new ones are
added until none is entered."""
import pathlib

import numpy as np

TIP = 0.005


def read_ply(path):
    """(vertices, triangles) of a binary file."""
    data = pathlib.Path(path).read_bytes()
    head, body = data.split(b"end_header\n", 1)
    counts = {line.split()[1]: int(line.split()[2]) for line in head.decode().splitlines() if line.startswith("element")}
    vertices = np.frombuffer(body, "<f4", 3 * counts["vertex"]).reshape(-1, 3).astype(float)
    faces = np.frombuffer(body, np.dtype([("n", "u1"), ("v", "<i4", 3)]), counts["face"], 12 * counts["vertex"])
    return vertices, faces["v"].astype(int)


def nearest_on_triangles(c, corners):
    """The point of each triangle that is nearest to c."""
    a, b, d = corners[:, 0], corners[:, 1], corners[:, 2]
    ab, ad = b - a, d - a
    normal = np.cross(ab, ad)
    square = np.maximum(np.einsum("ij,ij->i", normal, normal), 1e-300)
    w = c - a
    s = np.einsum("ij,ij->i", np.cross(w, ad), normal) / square
    t = np.einsum("ij,ij->i", np.cross(ab, w), normal) / square
    inside = (s >= 0) & (t >= 0) & (s + t <= 1)
    best = a + s[:, None] * ab + t[:, None] * ad
    distance = np.where(inside, np.linalg.norm(best - c, axis=1), np.inf)
    for p, q in ((a, b), (b, d), (d, a)):
        way = q - p
        share = np.clip(np.einsum("ij,ij->i", c - p, way) / np.maximum(np.einsum("ij,ij->i", way, way), 1e-300), 0, 1)
        point = p + share[:, None] * way
        far = np.linalg.norm(point - c, axis=1)
        nearer = far < distance
        best[nearer], distance[nearer] = point[nearer], far[nearer]
    return best, distance


class Mesh:
    def __init__(self, path):
        vertices, faces = read_ply(path)
        self.corners = vertices[faces]
        self.middle = self.corners.mean(axis=1)
        self.size = np.linalg.norm(self.corners - self.middle[:, None], axis=2).max(axis=1)

    def around(self, c, reach):
        """The part of the mesh that comes within `reach` of c, and a little more."""
        part = object.__new__(Mesh)
        kept = np.linalg.norm(self.middle - c, axis=1) < reach + self.size
        part.corners, part.middle, part.size = self.corners[kept], self.middle[kept], self.size[kept]
        return part


class Statics:
    """A tool of spheres that does not turn, on a mesh."""

    def __init__(self, mesh, tool):
        self.mesh, self.all, self.tool = mesh, mesh, tool

    def look_around(self, c, reach):
        """From now on the tool stays within `reach` of c, or next to the mesh there."""
        self.mesh = self.all.around(c, reach)

    def nearest(self, p):
        """(gap, normal) of that sphere of the tool at p which is nearest to the mesh."""
        centres, radii = p + self.tool.spheres[:, :3], self.tool.spheres[:, 3]
        mesh = self.mesh
        # Triangles lie in balls: what is farther than the far side of the nearest ball is not the nearest.
        far = (centres**2).sum(axis=1)[:, None] - 2 * centres @ mesh.middle.T + (mesh.middle**2).sum(axis=1)
        middle = np.sqrt(np.maximum(far, 0))
        low, high = (middle - mesh.size).clip(0), (middle + mesh.size).min(axis=1) + 1e-9
        least = (np.inf, None)
        for k in np.argsort(low.min(axis=1) - radii):
            if low[k].min() - radii[k] > least[0]:
                break
            points, distances = nearest_on_triangles(centres[k], mesh.corners[low[k] <= high[k]])
            i = int(np.argmin(distances))
            if distances[i] - radii[k] < least[0]:
                least = (distances[i] - radii[k], (centres[k] - points[i]) / max(distances[i], 1e-12))
        return least

    def gap(self, p):
        """Distance of the tool's spheres at p from the mesh; the centres are outside."""
        return self.nearest(p)[0]

    def fall(self, p, way, most):
        """Where the tool touches that goes from p along `way`; None when it does not within `most`."""
        gone = 0.0
        while gone < most:
            gap = self.gap(p + gone * way)
            if gap < 1e-8:
                return p + gone * way
            gone += gap
        return None

    def rest(self, hand, start):
        """Where the tool rests for the hand, next to `start`."""
        p, planes = np.array(start, float), []
        for _ in range(80):
            gap, normal = self.nearest(p)
            if gap > -1e-9 and planes:
                break
            planes.append((normal, normal @ p - gap))
            p = closest(hand, planes[-8:])
        return p


def closest(hand, planes):
    """The point next to `hand` with n . x >= b for each (n, b): the best of all sets of up to three that touch."""
    best, least = hand, np.inf
    count = len(planes)
    sets = [()] + [(i,) for i in range(count)] + [(i, j) for i in range(count) for j in range(i)]
    sets += [(i, j, k) for i in range(count) for j in range(i) for k in range(j)]
    for chosen in sets:
        x = hand
        if chosen:
            rows = np.array([planes[i][0] for i in chosen])
            b = np.array([planes[i][1] for i in chosen])
            x = hand + rows.T @ np.linalg.lstsq(rows @ rows.T, b - rows @ hand, rcond=1e-9)[0]
        if all(n @ x >= b - 1e-10 for n, b in planes):
            way = np.linalg.norm(x - hand)
            if way < least:
                best, least = x, way
    return best


def ripple(force, truth):
    """{mN rms and worst about the mean difference, degrees rms and worst} of the forces of a slide beside the exact ones."""
    strength = np.linalg.norm(force, axis=1)
    exact = np.linalg.norm(truth, axis=1)
    off = strength - exact
    off = off - off.mean()
    cosine = np.clip(np.einsum("ij,ij->i", force, truth) / (strength * exact), -1, 1)
    angle = np.degrees(np.arccos(cosine))
    return {"force_n": float(exact.mean()), "fat_mn": 1e3 * float((strength - exact).mean()), "rms_mn": 1e3 * float(np.sqrt((off**2).mean())),
            "worst_mn": 1e3 * float(np.abs(off).max()), "rms_deg": float(np.sqrt((angle**2).mean())), "worst_deg": float(angle.max())}
