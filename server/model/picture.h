// Picture of a mesh beside the spheres made from it, seen from the same place: parallel projection,
// depth buffers, two lights and a darkening of hollows. The spheres carry their distance outside
// the mesh as colour, blue at 0 to yellow at the bound; red is what they leave uncovered. Not RT.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/geometry/sphere.h"
#include "server/model/packing/mesh_distance.h"

namespace hapticd {

/// Rows from the top, three bytes (red, green, blue) per pixel.
struct Picture {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgb;
};

struct PictureOptions {
  int width = 1600;
  int height = 800;
  double bound = 0.0;  ///< distance outside that is shown in full yellow, m
};

/// Mesh left and spheres right, or above and below each other when the shape is long. y is up, or z
/// where the shape is flat along z; the longer of the other two axes runs from left to right.
/// `distance` is that of `mesh` (closed); sizes in [64, 8192], else std::invalid_argument. About 2
/// s.
[[nodiscard]] Picture draw_packing(const TriangleMesh& mesh, const MeshDistance& distance,
                                   std::span<const Sphere> spheres, const PictureOptions& options);

/// The bytes of a PNG file. Throws std::runtime_error when libpng fails.
[[nodiscard]] std::vector<std::uint8_t> encode_png(const Picture& picture);

}  // namespace hapticd
