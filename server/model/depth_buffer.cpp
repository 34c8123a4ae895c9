// See depth_buffer.h.
#include "server/model/depth_buffer.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hapticd {
namespace {

/// In pixels from the top left, depth in m.
Vector3 project(const View& view, const DepthBuffer& buffer, const Vector3& p) {
  const Vector3 d = p - view.centre;
  return {0.5 * buffer.width + d.dot(view.right) / view.pixel,
          0.5 * buffer.height - d.dot(view.up) / view.pixel, d.dot(view.toward)};
}

void set(DepthBuffer& buffer, int x, int y, double depth, const Vector3& normal) {
  const std::size_t i = buffer.at(x, y);
  if (depth <= buffer.depth[i]) return;
  buffer.depth[i] = depth;
  buffer.normal[i] = normal;
}

/// First pixel whose middle is at `low` or beyond, and last one whose middle is at `high` or
/// before, within the picture.
struct Range {
  int first, last;
};
Range pixels(double low, double high, int size) {
  return {static_cast<int>(std::clamp(std::ceil(low - 0.5), 0.0, static_cast<double>(size))),
          static_cast<int>(std::clamp(std::floor(high - 0.5), -1.0, size - 1.0))};
}

double cross_2d(const Vector3& a, const Vector3& b, double x, double y) {
  return (b.x() - a.x()) * (y - a.y()) - (b.y() - a.y()) * (x - a.x());
}

}  // namespace

DepthBuffer::DepthBuffer(int width_pixels, int height_pixels)
    : width(width_pixels),
      height(height_pixels),
      depth(static_cast<std::size_t>(width) * static_cast<std::size_t>(height),
            -std::numeric_limits<double>::infinity()),
      normal(depth.size(), Vector3{0.0, 0.0, 1.0}) {}

void draw(const TriangleMesh& mesh, const View& view, DepthBuffer& buffer) {
  for (const Triangle& t : mesh.triangles) {
    const auto [p, q, r] = corners(mesh, t);
    const Vector3 n = (q - p).cross(r - p).stableNormalized();
    Vector3 normal{n.dot(view.right), n.dot(view.up), n.dot(view.toward)};
    if (normal.z() < 0.0) normal = -normal;
    const Vector3 a = project(view, buffer, p);
    const Vector3 b = project(view, buffer, q);
    const Vector3 c = project(view, buffer, r);
    const double area = cross_2d(a, b, c.x(), c.y());
    if (area == 0.0) continue;
    const Range columns =
        pixels(std::min({a.x(), b.x(), c.x()}), std::max({a.x(), b.x(), c.x()}), buffer.width);
    const Range rows =
        pixels(std::min({a.y(), b.y(), c.y()}), std::max({a.y(), b.y(), c.y()}), buffer.height);
    for (int y = rows.first; y <= rows.last; ++y) {
      for (int x = columns.first; x <= columns.last; ++x) {
        const double u = cross_2d(b, c, x + 0.5, y + 0.5) / area;
        const double v = cross_2d(c, a, x + 0.5, y + 0.5) / area;
        const double w = 1.0 - u - v;
        if (u >= 0.0 && v >= 0.0 && w >= 0.0) {
          set(buffer, x, y, u * a.z() + v * b.z() + w * c.z(), normal);
        }
      }
    }
  }
}

void draw(std::span<const Sphere> spheres, const View& view, DepthBuffer& buffer) {
  for (const Sphere& sphere : spheres) {
    const Vector3 c = project(view, buffer, sphere.p);
    const double radius = sphere.r / view.pixel;
    const Range columns = pixels(c.x() - radius, c.x() + radius, buffer.width);
    const Range rows = pixels(c.y() - radius, c.y() + radius, buffer.height);
    for (int y = rows.first; y <= rows.last; ++y) {
      for (int x = columns.first; x <= columns.last; ++x) {
        const double dx = (x + 0.5 - c.x()) / radius;
        const double dy = (c.y() - y - 0.5) / radius;
        const double square = 1.0 - dx * dx - dy * dy;
        if (square < 0.0) continue;
        const double dz = std::sqrt(square);
        set(buffer, x, y, c.z() + sphere.r * dz, Vector3{dx, dy, dz});
      }
    }
  }
}

Vector3 point_at(const View& view, const DepthBuffer& buffer, int x, int y, double depth) {
  return view.centre + view.right * ((x + 0.5 - 0.5 * buffer.width) * view.pixel) +
         view.up * ((0.5 * buffer.height - y - 0.5) * view.pixel) + view.toward * depth;
}

}  // namespace hapticd
