// The collision query beside exhaustive search, plain and in AVX2, tools of 36 to 4096
// spheres against seven strings and against a Guqin-like body, touching (gap 0.02 mm), near (2 mm)
// and far (200 mm), margin 5 mm. Each benchmark cycles through 64 poses. Counters: contacts, tests
// (bounds evaluated), p50 and p99.9 of single calls in ns (clock overhead of about 25 ns included).
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <tuple>
#include <vector>

#include "core/collision/query.h"
#include "core/tree/sphere_tree.h"
#include "tests/benchmark/avx2_brute_force.h"
#include "tests/benchmark/plain_brute_force.h"
#include "tests/support/contact_scenes.h"

namespace hapticd::test {
namespace {

constexpr int kPoses = 64;

/// A tool, what it touches, and the poses to query it at.
struct QueryScene {
  SphereTree tool;
  std::vector<Capsule> capsules;
  SphereTree body;
  std::vector<BodyView> bodies;
  std::vector<Pose> poses;

  [[nodiscard]] ObstaclesView obstacles() const { return {capsules, bodies}; }
};

/// Tools as the benchmarks name them: 36 is the hand, all others blobs.
std::vector<Sphere> tool_spheres(int count) {
  return count == 36 ? hand_spheres() : blob_spheres(count);
}

/// Poses around the middle of the obstacles, turned at random, lowered until the gap is `gap`.
void find_poses(QueryScene& scene, double gap) {
  SplitMix64 random(5);
  const auto set = std::make_unique<ContactSet>();
  while (scene.poses.size() < kPoses) {
    Pose X_WG{random_rotation(random),
              {random.uniform(-0.3, 0.3), 0.0, random.uniform(-0.04, 0.04)}};
    double low = 0.0;
    double high = 1.0;
    for (int k = 0; k < 60; ++k) {
      X_WG.p.y() = 0.5 * (low + high);
      find_contacts({scene.tool.view(), X_WG}, scene.obstacles(), {}, *set);
      (set->minimum_gap > gap ? high : low) = X_WG.p.y();
    }
    scene.poses.push_back(X_WG);
  }
}

std::unique_ptr<QueryScene> strings_scene(int tool, double gap) {
  auto scene = std::make_unique<QueryScene>();
  scene->tool = build_sphere_tree(tool_spheres(tool));
  scene->capsules = seven_strings();
  find_poses(*scene, gap);
  return scene;
}

std::unique_ptr<QueryScene> body_scene(int tool, int body, double gap) {
  auto scene = std::make_unique<QueryScene>();
  scene->tool = build_sphere_tree(tool_spheres(tool));
  scene->body = build_sphere_tree(body == 4000 ? slab_spheres(160, 25) : slab_spheres(250, 40));
  scene->bodies = {{scene->body.view(), Pose{}}};
  find_poses(*scene, gap);
  return scene;
}

/// Runs `query(pose, set)` over the poses, first call by call for the percentiles, then in bulk.
template <typename Query>
void run(benchmark::State& state, const QueryScene& scene, int timed_calls, const Query& query) {
  using Clock = std::chrono::steady_clock;
  const auto set = std::make_unique<ContactSet>();
  std::vector<double> nanoseconds;
  double contacts = 0.0;
  double tests = 0.0;
  for (int k = 0; k < timed_calls; ++k) {
    const Pose& X_WG = scene.poses[static_cast<std::size_t>(k % kPoses)];
    const auto start = Clock::now();
    query(X_WG, *set);
    const auto stop = Clock::now();
    nanoseconds.push_back(std::chrono::duration<double, std::nano>(stop - start).count());
    contacts += static_cast<double>(set->contacts.size());
    tests += static_cast<double>(set->tests);
  }
  std::sort(nanoseconds.begin(), nanoseconds.end());
  const auto percentile = [&](double share) {
    return nanoseconds[static_cast<std::size_t>(share * (timed_calls - 1))];
  };
  state.counters["contacts"] = contacts / timed_calls;
  state.counters["tests"] = tests / timed_calls;
  state.counters["p50_ns"] = percentile(0.5);
  state.counters["p99.9_ns"] = percentile(0.999);

  std::size_t k = 0;
  for (auto _ : state) {
    query(scene.poses[k++ % kPoses], *set);
    benchmark::DoNotOptimize(set->minimum_gap);
  }
}

void run_tree(benchmark::State& state, const QueryScene& scene) {
  run(state, scene, 20000, [&](const Pose& X_WG, ContactSet& set) {
    find_contacts({scene.tool.view(), X_WG}, scene.obstacles(), {}, set);
  });
}

/// Keys of all contacts in a fixed order.
std::vector<std::tuple<std::int32_t, TreeSphereId, TreeSphereId>> sorted_pairs(
    const ContactSet& set) {
  std::vector<std::tuple<std::int32_t, TreeSphereId, TreeSphereId>> pairs;
  for (const Contact& contact : set.contacts) {
    pairs.emplace_back(contact.key.obstacle, contact.key.tool_sphere, contact.key.obstacle_sphere);
  }
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

/// Ends the program when exhaustive search finds something else than the trees: then the times mean
/// nothing. Sets that exceed the capacity are told apart by their smallest gap alone.
template <typename Brute>
void check_same_results(const QueryScene& scene, Brute& brute) {
  constexpr std::size_t kChecked = 8;
  const auto ours = std::make_unique<ContactSet>();
  const auto theirs = std::make_unique<ContactSet>();
  for (std::size_t k = 0; k < kChecked; ++k) {
    find_contacts({scene.tool.view(), scene.poses[k]}, scene.obstacles(), {}, *ours);
    brute.find(scene.poses[k], scene.obstacles(), {}, *theirs);
    const bool same_gap = std::abs(ours->minimum_gap - theirs->minimum_gap) <= 1e-14;
    const bool same_pairs =
        theirs->contacts.size() > kMaxCandidates || sorted_pairs(*ours) == sorted_pairs(*theirs);
    if (same_gap && same_pairs) continue;
    std::fprintf(stderr, "pose %zu: the trees and exhaustive search disagree\n", k);
    std::abort();
  }
}

template <typename Brute>
void run_brute_force(benchmark::State& state, const QueryScene& scene, int timed_calls) {
  Brute brute(scene.tool.view());
  check_same_results(scene, brute);
  run(state, scene, timed_calls,
      [&](const Pose& X_WG, ContactSet& set) { brute.find(X_WG, scene.obstacles(), {}, set); });
}

struct Distance {
  const char* name;
  double gap;
};

constexpr Distance kDistances[] = {{"touching", 2e-5}, {"near", 2e-3}, {"far", 0.2}};

/// Registers the tree and both exhaustive searches over one scene, made on first use.
void add_group(const std::string& name, int brute_calls,
               std::unique_ptr<QueryScene> (*make)(int, int, double), int tool, int body,
               double gap) {
  benchmark::RegisterBenchmark((name + "/tree").c_str(), [=](benchmark::State& state) {
    run_tree(state, *make(tool, body, gap));
  });
  benchmark::RegisterBenchmark((name + "/brute_force").c_str(), [=](benchmark::State& state) {
    run_brute_force<PlainBruteForce>(state, *make(tool, body, gap), brute_calls);
  });
  benchmark::RegisterBenchmark((name + "/brute_force_avx2").c_str(), [=](benchmark::State& state) {
    run_brute_force<Avx2BruteForce>(state, *make(tool, body, gap), brute_calls);
  });
}

const bool kRegistered = [] {
  for (const Distance& distance : kDistances) {
    for (const int tool : {36, 64, 256, 1000, 4096}) {
      add_group(
          "strings/" + std::to_string(tool) + "x7/" + distance.name, 20000,
          [](int t, int, double gap) { return strings_scene(t, gap); }, tool, 0, distance.gap);
    }
    for (const int body : {4000, 10000}) {
      for (const int tool : {36, 1000, 4096}) {
        add_group("body/" + std::to_string(tool) + "x" + std::to_string(body) + "/" + distance.name,
                  200, body_scene, tool, body, distance.gap);
      }
    }
  }
  return true;
}();

}  // namespace
}  // namespace hapticd::test

// tests/support brings doctest's main in an archive; this one comes first.
BENCHMARK_MAIN();
