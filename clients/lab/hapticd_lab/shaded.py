"""Small pictures of spheres: parallel projection, a depth buffer, one light. For figures of sphere-trees."""
from __future__ import annotations

import numpy

LIGHT = numpy.array([-0.4, 0.75, 0.55]) / numpy.linalg.norm([-0.4, 0.75, 0.55])


def view(yaw: float, pitch: float) -> numpy.ndarray:
    """Rotation R_EW from the world (y up) to the eye: x right, y up, z towards the eye. Radians."""
    c, s = numpy.cos(yaw), numpy.sin(yaw)
    turn = numpy.array([[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]])
    c, s = numpy.cos(pitch), numpy.sin(pitch)
    return numpy.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]]) @ turn


def window(spheres: numpy.ndarray, eye: numpy.ndarray) -> numpy.ndarray:
    """The smallest window that shows spheres (n x 4): (x0, x1, y0, y1) in the eye's frame."""
    centres, radii = spheres[:, :3] @ eye.T, spheres[:, 3]
    low, high = (centres[:, :2] - radii[:, None]).min(axis=0), (centres[:, :2] + radii[:, None]).max(axis=0)
    return numpy.array([low[0], high[0], low[1], high[1]])


def draw_spheres(spheres: numpy.ndarray, colors: numpy.ndarray, eye: numpy.ndarray, extent: numpy.ndarray, width: int) -> numpy.ndarray:
    """A picture (rows x width x 3, from 0 to 1, white behind) of spheres (n x 4, m) in `colors` (n x 3), of the window `extent`."""
    centres, radii = spheres[:, :3] @ eye.T, spheres[:, 3]
    scale = width / (extent[1] - extent[0])
    height = max(1, round((extent[3] - extent[2]) * scale))
    picture, depth = numpy.ones((height, width, 3)), numpy.full((height, width), -numpy.inf)
    for (x, y, z), radius, color in zip(centres, radii, colors):
        column, row, reach = (x - extent[0]) * scale, (extent[3] - y) * scale, radius * scale
        left, right = max(0, int(column - reach)), min(width, int(column + reach) + 2)
        top, bottom = max(0, int(row - reach)), min(height, int(row + reach) + 2)
        if left >= right or top >= bottom:
            continue
        dx = (numpy.arange(left, right) + 0.5 - column)[None, :] / reach
        dy = (row - numpy.arange(top, bottom) - 0.5)[:, None] / reach
        square = dx * dx + dy * dy
        nz = numpy.sqrt(numpy.maximum(0.0, 1.0 - square))
        nearer = (square <= 1.0) & (z + radius * nz > depth[top:bottom, left:right])
        shade = 0.42 + 0.58 * numpy.maximum(0.0, dx * LIGHT[0] + dy * LIGHT[1] + nz * LIGHT[2])
        depth[top:bottom, left:right][nearer] = (z + radius * nz)[nearer]
        picture[top:bottom, left:right][nearer] = (shade[..., None] * color)[nearer]
    return picture
