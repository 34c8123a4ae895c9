// Triangles and spheres drawn into a buffer of depths and normals, by parallel projection. Not RT.
#pragma once

#include <span>
#include <vector>

#include "core/geometry/sphere.h"
#include "server/model/packing/triangle_mesh.h"

namespace hapticd {

/// Where the picture is taken from.
struct View {
  Vector3 right{1.0, 0.0, 0.0};
  Vector3 up{0.0, 1.0, 0.0};
  Vector3 toward{0.0, 0.0, 1.0};  ///< to the viewer; unit, normal to the others
  Vector3 centre{0.0, 0.0, 0.0};  ///< shown in the middle, m
  double pixel = 1.0;             ///< m per pixel
};

struct DepthBuffer {
  DepthBuffer(int width_pixels, int height_pixels);

  [[nodiscard]] std::size_t at(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(x);
  }

  int width, height;
  std::vector<double> depth;    ///< toward the viewer, m; -infinity where nothing is
  std::vector<Vector3> normal;  ///< unit, in the view's axes
};

/// Draws all triangles, with flat normals; both faces are seen.
void draw(const TriangleMesh& mesh, const View& view, DepthBuffer& buffer);

/// Draws all spheres.
void draw(std::span<const Sphere> spheres, const View& view, DepthBuffer& buffer);

/// The point of space seen at the middle of a pixel, at a depth.
[[nodiscard]] Vector3 point_at(const View& view, const DepthBuffer& buffer, int x, int y,
                               double depth);

}  // namespace hapticd
