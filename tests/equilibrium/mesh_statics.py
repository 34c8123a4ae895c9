"""The exact statics of a round tip on the mesh of a body, and what a slide on the body's tree feels beside it: its ripple. SI.

The tip's centre goes where it is next to the hand with no point of the mesh nearer than its radius; the force is kt times the way. Planes
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

    def near(self, c, reach):
        return self.corners[np.linalg.norm(self.middle - c, axis=1) < reach + self.size]

    def rest(self, hand, start, reach=0.02):
        """The centre of the tip for the hand, next to `start`."""
        hand, c, planes = np.asarray(hand, float), np.array(start, float), []
        corners = self.near(c, reach)
        for _ in range(60):
            points, distances = nearest_on_triangles(c, corners)
            k = int(np.argmin(distances))
            if distances[k] > TIP - 1e-9 and planes:
                break
            n = (c - points[k]) / distances[k]
            planes.append((n, n @ points[k] + TIP))
            c = closest(hand, planes[-8:])
        return c


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
