// See picture.h.
#include "server/model/picture.h"

#include <png.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "server/model/depth_buffer.h"

namespace hapticd {
namespace {

/// Samples per pixel and direction. 2: edges are smooth enough.
constexpr int kSamples = 2;
/// Share of a panel that the shape fills.
constexpr double kFill = 0.9;
/// Width to height of the shape above which the panels are put above each other.
constexpr double kLongShape = 1.6;
/// A shape flatter than this along z, compared with its other sides, lies on its back: z is up.
constexpr double kFlatAlongZ = 0.45;
/// Viewer's turn to the side and height, as parts of the direction.
constexpr double kSideways = 0.35;
constexpr double kUpwards = 0.55;
/// Depth by which the mesh must stick out of the spheres to be shown as uncovered, in samples: less
/// would show rounding.
constexpr double kUncoveredDepth = 0.02;

/// Red, green, blue in [0, 1]; linear enough for a drawing.
using Colour = Vector3;
const Colour kMeshColour{0.86, 0.80, 0.70};
const Colour kUncoveredColour{0.90, 0.05, 0.05};
const Colour kNearColour{0.38, 0.60, 0.90};
const Colour kFarColour{1.00, 0.88, 0.42};

bool is_background(double depth) { return depth == -std::numeric_limits<double>::infinity(); }

View choose_view(const TriangleMesh& mesh) {
  Vector3 low = mesh.vertices.front();
  Vector3 high = low;
  for (const Vector3& p : mesh.vertices) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const Vector3 extent = high - low;
  const int up = extent.z() < kFlatAlongZ * std::min(extent.x(), extent.y()) ? 2 : 1;
  const int one = 0;
  const int other = up == 1 ? 2 : 1;
  const int across = extent[one] >= extent[other] ? one : other;
  const int along = across == one ? other : one;
  Vector3 toward{0.0, 0.0, 0.0};
  toward[along] = up == 2 ? -1.0 : 1.0;
  toward[across] = kSideways;
  toward[up] = kUpwards;
  View view;
  view.toward = toward.normalized();
  view.right = Vector3::Unit(up).cross(view.toward).normalized();
  view.up = view.toward.cross(view.right);
  view.centre = 0.5 * (low + high);
  return view;
}

/// Sides of the rectangle that holds all of the shape around the view's centre, m.
struct Extent {
  double width = 0.0, height = 0.0;
};

Extent projected_extent(const TriangleMesh& mesh, std::span<const Sphere> spheres,
                        const View& view) {
  Extent half;
  const auto take = [&](const Vector3& p, double r) {
    half.width = std::max(half.width, std::fabs((p - view.centre).dot(view.right)) + r);
    half.height = std::max(half.height, std::fabs((p - view.centre).dot(view.up)) + r);
  };
  for (const Vector3& p : mesh.vertices) take(p, 0.0);
  for (const Sphere& sphere : spheres) take(sphere.p, sphere.r);
  return {2.0 * half.width, 2.0 * half.height};
}

/// How much of the sky a sample sees, from the depths around it: 1 all of it.
double openness(const DepthBuffer& buffer, int x, int y, double pixel) {
  constexpr int kDirections = 8;
  constexpr std::array<std::array<double, 2>, kDirections> kWays{{{1.0, 0.0},
                                                                  {0.7, 0.7},
                                                                  {0.0, 1.0},
                                                                  {-0.7, 0.7},
                                                                  {-1.0, 0.0},
                                                                  {-0.7, -0.7},
                                                                  {0.0, -1.0},
                                                                  {0.7, -0.7}}};
  const double depth = buffer.depth[buffer.at(x, y)];
  // The surface itself, tilted, hides nothing; steep ones are left out of it.
  const Vector3& n = buffer.normal[buffer.at(x, y)];
  const double rise_x = -n.x() / std::max(n.z(), 0.2);
  const double rise_y = n.y() / std::max(n.z(), 0.2);
  double hidden = 0.0;
  for (const double radius : {4.0, 10.0, 24.0}) {
    for (const auto& way : kWays) {
      const int u = x + static_cast<int>(way[0] * radius);
      const int v = y + static_cast<int>(way[1] * radius);
      if (u < 0 || v < 0 || u >= buffer.width || v >= buffer.height) continue;
      const double plane = depth + pixel * (rise_x * (u - x) + rise_y * (v - y));
      // What stands far in front casts no shadow here.
      const double slope = (buffer.depth[buffer.at(u, v)] - plane) / (radius * pixel);
      if (slope > 0.0) hidden += std::min(slope, 1.0) / (1.0 + 0.3 * slope * slope);
    }
  }
  return std::max(0.0, 1.0 - hidden / 16.0);
}

Colour shade(const Colour& colour, const Vector3& normal, double open) {
  const Vector3 key = Vector3{-0.45, 0.65, 0.62}.normalized();
  const Vector3 fill = Vector3{0.75, 0.10, 0.65}.normalized();
  const double lambert =
      0.40 + 0.62 * std::max(0.0, normal.dot(key)) + 0.24 * std::max(0.0, normal.dot(fill));
  const Vector3 half = (key + Vector3{0.0, 0.0, 1.0}).normalized();
  const double gloss = 0.12 * std::pow(std::max(0.0, normal.dot(half)), 30.0);
  const double light = lambert * (0.30 + 0.70 * open);
  return (colour * light).array() + gloss * open;
}

Colour background(int y, int height) {
  const double share = static_cast<double>(y) / height;
  return Colour{0.97, 0.975, 0.985} * (1.0 - share) + Colour{0.86, 0.87, 0.89} * share;
}

/// Blue at the surface, yellow at the bound.
Colour distance_colour(double distance, double bound) {
  const double share = bound > 0.0 ? std::clamp(distance / bound, 0.0, 1.0) : 0.0;
  return kNearColour * (1.0 - share) + kFarColour * share;
}

/// One of the two halves, drawn with kSamples times its size.
struct Panel {
  int left, top, width, height;
};

/// `colour` gives the colour of the sample at (x, y).
template <typename ColourOf>
void finish(const DepthBuffer& buffer, const View& view, const Panel& panel, const ColourOf& colour,
            Picture& picture) {
  for (int y = 0; y < panel.height; ++y) {
    for (int x = 0; x < panel.width; ++x) {
      Colour sum{0.0, 0.0, 0.0};
      for (int k = 0; k < kSamples * kSamples; ++k) {
        const int u = x * kSamples + k % kSamples;
        const int v = y * kSamples + k / kSamples;
        const std::size_t i = buffer.at(u, v);
        sum += is_background(buffer.depth[i])
                   ? background(y, panel.height)
                   : shade(colour(u, v), buffer.normal[i], openness(buffer, u, v, view.pixel));
      }
      sum /= kSamples * kSamples;
      const auto at =
          3 * (static_cast<std::size_t>(panel.top + y) * static_cast<std::size_t>(picture.width) +
               static_cast<std::size_t>(panel.left + x));
      for (int c = 0; c < 3; ++c) {
        picture.rgb[at + static_cast<std::size_t>(c)] =
            static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(sum[c], 0.0, 1.0)));
      }
    }
  }
}

std::array<Panel, 2> panels(const PictureOptions& options, const Extent& extent) {
  if (extent.width > kLongShape * extent.height) {
    const int height = options.height / 2;
    return {{{0, 0, options.width, height}, {0, height, options.width, options.height - height}}};
  }
  const int width = options.width / 2;
  return {{{0, 0, width, options.height}, {width, 0, options.width - width, options.height}}};
}

}  // namespace

Picture draw_packing(const TriangleMesh& mesh, const MeshDistance& distance,
                     std::span<const Sphere> spheres, const PictureOptions& options) {
  const auto fits = [](int size) { return size >= 64 && size <= 8192; };
  if (!fits(options.width) || !fits(options.height)) {
    throw std::invalid_argument("a picture has from 64 to 8192 pixels per side");
  }
  if (mesh.triangles.empty()) throw std::invalid_argument("no mesh to draw");
  View view = choose_view(mesh);
  const Extent extent = projected_extent(mesh, spheres, view);
  const std::array<Panel, 2> halves = panels(options, extent);
  view.pixel = std::max(extent.width / halves[0].width, extent.height / halves[0].height) /
               (kFill * kSamples);
  if (!(view.pixel > 0.0)) view.pixel = 1.0;

  Picture picture{options.width, options.height, {}};
  picture.rgb.resize(3 * static_cast<std::size_t>(options.width) *
                     static_cast<std::size_t>(options.height));
  DepthBuffer surface(kSamples * halves[0].width, kSamples * halves[0].height);
  draw(mesh, view, surface);
  finish(
      surface, view, halves[0], [](int, int) { return kMeshColour; }, picture);

  // The same mesh once more, for what the spheres leave uncovered.
  DepthBuffer bare(kSamples * halves[1].width, kSamples * halves[1].height);
  draw(mesh, view, bare);
  DepthBuffer both(bare.width, bare.height);
  draw(spheres, view, both);
  const double tolerance = kUncoveredDepth * view.pixel;
  std::vector<bool> uncovered(both.depth.size());
  for (std::size_t i = 0; i < both.depth.size(); ++i) {
    uncovered[i] = bare.depth[i] > both.depth[i] + tolerance;
    if (!uncovered[i]) continue;
    both.depth[i] = bare.depth[i];
    both.normal[i] = bare.normal[i];
  }
  finish(
      both, view, halves[1],
      [&](int x, int y) {
        const std::size_t i = both.at(x, y);
        if (uncovered[i]) return kUncoveredColour;
        const Vector3 p = point_at(view, both, x, y, both.depth[i]);
        return distance_colour(distance.signed_distance(p), options.bound);
      },
      picture);
  return picture;
}

std::vector<std::uint8_t> encode_png(const Picture& picture) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(picture.width);
  image.height = static_cast<png_uint_32>(picture.height);
  image.format = PNG_FORMAT_RGB;
  png_alloc_size_t size = 0;
  std::vector<std::uint8_t> bytes;
  bool good =
      png_image_write_to_memory(&image, nullptr, &size, 0, picture.rgb.data(), 0, nullptr) != 0;
  if (good) {
    bytes.resize(size);
    good = png_image_write_to_memory(&image, bytes.data(), &size, 0, picture.rgb.data(), 0,
                                     nullptr) != 0;
    bytes.resize(size);
  }
  if (!good) throw std::runtime_error(std::string("no PNG written: ") + image.message);
  return bytes;
}

}  // namespace hapticd
