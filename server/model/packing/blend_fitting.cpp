// See blend_fitting.h.
#include "server/model/packing/blend_fitting.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <stdexcept>

#include "core/collision/blended_surface.h"
#include "core/tree/sphere_tree.h"
#include "server/model/packing/parallel_chunks.h"
#include "server/model/packing/surface_patches.h"

namespace hapticd {
namespace {

/// Longest side of a patch as a share of the reach of a ball. Smaller: more that sticks out unseen,
/// less time.
constexpr double kPatchSize = 0.4;
/// How far above the surface it is to be smooth too, m: the radius of a fingertip, about.
constexpr double kTip = 4e-3;
/// How far outside the mesh a tip is to feel it, as a share of the bound. Small leaves at edges are
/// felt fatter from afar, so that the mesh is covered there first. Less: more leaves that have to
/// grow, and so more ripple.
constexpr double kOutside = 0.6;
/// Samples of a leaf that least squares go by, about.
constexpr std::size_t kSamples = 24;
/// Rounds of least squares, and how far each goes; above 2 they diverge.
constexpr int kRounds = 14;
constexpr double kRelaxation = 1.7;
/// Rounds of growth, at most, and what grows in each over what sticks out. Larger: fewer rounds,
/// and leaves that are larger than they need to be.
constexpr int kGrowthRounds = 200;
constexpr double kGrowth = 1.2;
/// What leaves grow by at least, m.
constexpr double kLeastGrowth = 1e-7;
/// Weight below which the samples say nothing of a leaf.
constexpr double kLeastWeight = 1e-3;
constexpr std::int64_t kChunk = 4096;

/// A place where the blended surface is looked at.
struct Sample {
  Vector3 p;
  double distance;  ///< from the mesh, m
};

/// What a sample says.
struct Reading {
  double excess = 0.0;  ///< phi less the distance from the mesh, m
  BlendShares blend;
};

SphereTree blended(const std::vector<Sphere>& leaves, double width) {
  SphereTree tree = build_sphere_tree(leaves);
  blend_surface(width, tree);
  return tree;
}

/// Reads all samples and calls take(sample index, Reading) in their order.
template <typename Take>
void read_all(const SphereTreeView& tree, const std::vector<Sample>& samples, int threads,
              const Take& take) {
  const auto count = static_cast<std::int64_t>(samples.size());
  const std::int64_t block = kChunk * std::max(threads, 1);
  std::vector<Reading> readings(static_cast<std::size_t>(std::min(count, block)));
  for (std::int64_t first = 0; first < count; first += block) {
    const std::int64_t size = std::min(block, count - first);
    for_chunks(size, kChunk, threads, [&](std::int64_t, std::int64_t begin, std::int64_t end) {
      for (std::int64_t i = begin; i < end; ++i) {
        const Sample& sample = samples[static_cast<std::size_t>(first + i)];
        Reading& reading = readings[static_cast<std::size_t>(i)];
        find_shares(tree, sample.p, reading.blend);
        reading.excess = reading.blend.distance - sample.distance;
      }
    });
    for (std::int64_t i = 0; i < size; ++i) {
      take(static_cast<std::size_t>(first + i), readings[static_cast<std::size_t>(i)]);
    }
  }
}

/// The middles of patches, every other one a tip's radius above the surface where that is free;
/// `wanted` of them, about.
std::vector<Sample> middles(const SurfacePatches& surface, const MeshDistance& distance,
                            std::size_t wanted) {
  std::vector<Sample> samples;
  const std::size_t stride = std::max<std::size_t>(surface.patches.size() / wanted, 1);
  for (std::size_t i = 0; i < surface.patches.size(); i += stride) {
    const Patch& patch = surface.patches[i];
    const Vector3 p = (patch.a + patch.b + patch.c) / 3.0;
    const Vector3 tip = p + kTip * patch.normal;
    NearestPoint nearer;
    if (!distance.find_nearer(tip, kTip * (1.0 - 1e-9), nearer)) {
      samples.push_back({tip, kTip});
    } else {
      samples.push_back({p, 0.0});
    }
  }
  return samples;
}

/// One corner of every patch, which others share, and its middle.
std::vector<Sample> corners_and_middles(const SurfacePatches& surface) {
  std::vector<Sample> samples;
  for (const Patch& patch : surface.patches) {
    samples.push_back({patch.a, 0.0});
    samples.push_back({(patch.a + patch.b + patch.c) / 3.0, 0.0});
  }
  return samples;
}

/// Simultaneous iterative reconstruction (SIRT) of the radii.
void smooth(const std::vector<Sample>& samples, double goal, const BlendOptions& options,
            std::vector<Sphere>& leaves) {
  for (int round = 0; round < kRounds; ++round) {
    const SphereTree tree = blended(leaves, options.width);
    std::vector<double> sum(leaves.size(), 0.0);
    std::vector<double> weight(leaves.size(), 0.0);
    read_all(tree.view(), samples, options.threads, [&](std::size_t, const Reading& reading) {
      for (std::size_t k = 0; k < reading.blend.count; ++k) {
        const BlendShare& one = reading.blend.share[k];
        sum[static_cast<std::size_t>(one.leaf)] += one.share * (reading.excess - goal);
        weight[static_cast<std::size_t>(one.leaf)] += one.share;
      }
    });
    for (std::size_t k = 0; k < leaves.size(); ++k) {
      if (weight[k] < kLeastWeight) continue;
      leaves[k].r = std::max(leaves[k].r + kRelaxation * sum[k] / weight[k], 0.0);
    }
  }
}

/// How far the samples are off.
BlendFit measure(const std::vector<Sample>& samples, const BlendOptions& options,
                 const std::vector<Sphere>& leaves) {
  BlendFit fit;
  double sum = 0.0;
  const SphereTree tree = blended(leaves, options.width);
  read_all(tree.view(), samples, options.threads, [&](std::size_t, const Reading& reading) {
    fit.outer = std::max(fit.outer, -reading.excess);
    fit.inner = std::max(fit.inner, reading.excess);
    sum += std::max(-reading.excess, 0.0);
  });
  fit.mean = sum / static_cast<double>(std::max<std::size_t>(samples.size(), 1));
  return fit;
}

/// Leaves grow until no sample sticks out. As they grow, what is covered
/// stays so: each round looks at the rest alone.
void cover(std::vector<Sample> samples, const BlendOptions& options, std::vector<Sphere>& leaves) {
  for (int round = 0; round < kGrowthRounds && !samples.empty(); ++round) {
    std::vector<double> growth(leaves.size(), 0.0);
    std::vector<Sample> out;
    const SphereTree tree = blended(leaves, options.width);
    read_all(tree.view(), samples, options.threads, [&](std::size_t i, const Reading& reading) {
      if (!(reading.excess > 0.0)) return;
      out.push_back(samples[i]);
      const auto& share = reading.blend.share;
      const auto most = std::max_element(
          share.begin(), share.begin() + static_cast<std::ptrdiff_t>(reading.blend.count),
          [](const BlendShare& a, const BlendShare& b) { return a.share < b.share; });
      double& grows = growth[static_cast<std::size_t>(most->leaf)];
      grows = std::max(grows, kGrowth * reading.excess + kLeastGrowth);
    });
    for (std::size_t k = 0; k < leaves.size(); ++k) leaves[k].r += growth[k];
    samples.swap(out);
  }
}

}  // namespace

BlendFit fit_blend(const TriangleMesh& mesh, const MeshDistance& distance,
                   const BlendOptions& options, std::vector<Sphere>& leaves) {
  const SurfacePatches surface =
      divide_surface(mesh, distance, {options.bound, kPatchSize, options.threads});
  smooth(middles(surface, distance, kSamples * leaves.size()), -kOutside * options.bound, options,
         leaves);
  const std::vector<Sample> samples = corners_and_middles(surface);
  cover(samples, options, leaves);
  return measure(samples, options, leaves);
}

}  // namespace hapticd
