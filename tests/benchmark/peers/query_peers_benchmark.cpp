// The collision query beside Bullet's btDbvt and FCL's dynamic AABB tree (peer_query.h says how
// they are used): a tool of 1000 spheres against seven strings and against bodies of 4000 and
// 10 000, 64 poses turned at random whose smallest gap is 0.02 mm (touching) or 0.2 m (far), margin
// 5 mm. Counter: pairs, the mean number found, the same for all.
#include <benchmark/benchmark.h>

#include <limits>
#include <memory>
#include <string>

#include "tests/benchmark/peers/peer_query.h"
#include "tests/benchmark/tick_scene.h"
#include "tests/support/contact_scenes.h"

namespace hapticd::test {
namespace {

constexpr double kMargin = 5e-3;
constexpr int kPoses = 64;

std::array<double, 3> plain(const Vector3& p) { return {p.x(), p.y(), p.z()}; }

std::vector<PeerSphere> plain(const std::vector<Sphere>& spheres) {
  std::vector<PeerSphere> out;
  for (const Sphere& sphere : spheres) out.push_back({plain(sphere.p), sphere.r});
  return out;
}

PeerPose plain(const Pose& X) {
  const Matrix3 R = X.q.toRotationMatrix();
  return {{R(0, 0), R(0, 1), R(0, 2), R(1, 0), R(1, 1), R(1, 2), R(2, 0), R(2, 1), R(2, 2)},
          plain(X.p)};
}

/// What is queried, for us and for the peers.
struct QueryTask {
  std::unique_ptr<RenderingScene> scene;
  PeerScene peer_scene;
  std::vector<Pose> X_WG;
};

QueryTask make_task(const TickParts& parts, double gap) {
  QueryTask task{std::make_unique<RenderingScene>(parts.tool_G), {}, {}};
  task.scene->capsules_W = parts.capsules_W;
  if (!parts.body_W.empty()) task.scene->add_body(parts.body_W, Pose{});
  task.peer_scene = {plain(parts.tool_G), plain(parts.body_W), {}};
  for (const Capsule& capsule : parts.capsules_W)
    task.peer_scene.capsules_W.push_back({plain(capsule.p_A), plain(capsule.p_B), capsule.r});
  SplitMix64 random(5);
  for (int k = 0; k < kPoses; ++k) {
    Pose X_WG{random_rotation(random),
              {random.uniform(-0.3, 0.3), 0.0, random.uniform(-0.04, 0.04)}};
    X_WG.p.y() = contact_height(*task.scene, X_WG, gap);
    task.X_WG.push_back(X_WG);
  }
  return task;
}

/// Times `count(k)` over the poses.
template <typename CountPairs>
void run(benchmark::State& state, const CountPairs& count) {
  double pairs = 0.0;
  for (std::size_t k = 0; k < kPoses; ++k) pairs += count(k);
  state.counters["pairs"] = pairs / kPoses;
  std::size_t k = 0;
  for (auto _ : state) benchmark::DoNotOptimize(count(k++ % kPoses));
}

void run_ours_within(benchmark::State& state, const QueryTask& task, double horizon) {
  const auto contacts = std::make_unique<ContactSet>();
  run(state, [&](std::size_t k) {
    find_contacts({task.scene->tool(), task.X_WG[k]}, task.scene->obstacles(),
                  {.margin = kMargin, .horizon = horizon}, *contacts);
    return static_cast<int>(contacts->contacts.size());
  });
}

/// Pairs only, which is what the peers return.
void run_ours(benchmark::State& state, const QueryTask& task) {
  run_ours_within(state, task, kMargin);
}

/// Pairs and the true minimum gap, however far.
void run_ours_with_gap(benchmark::State& state, const QueryTask& task) {
  run_ours_within(state, task, std::numeric_limits<double>::infinity());
}

template <typename Peer>
void run_peer(benchmark::State& state, const QueryTask& task) {
  Peer peer(task.peer_scene, kMargin);
  std::vector<PeerPose> poses;
  for (const Pose& X_WG : task.X_WG) poses.push_back(plain(X_WG));
  run(state, [&](std::size_t k) { return peer.pairs(poses[k]); });
}

TickParts strings() { return {blob_spheres(1000), seven_strings(), {}}; }
TickParts body_4000() { return {blob_spheres(1000), {}, slab_spheres(160, 25)}; }
TickParts body_10000() { return {blob_spheres(1000), {}, slab_spheres(250, 40)}; }

const bool kRegistered = [] {
  const std::pair<const char*, TickParts (*)()> scenes[] = {
      {"strings/1000x7", strings}, {"body/1000x4000", body_4000}, {"body/1000x10000", body_10000}};
  const std::pair<const char*, double> gaps[] = {{"touching", 2e-5}, {"far", 0.2}};
  const std::pair<const char*, void (*)(benchmark::State&, const QueryTask&)> queries[] = {
      {"ours", run_ours},
      {"ours_and_minimum_gap", run_ours_with_gap},
      {"bullet_btDbvt", run_peer<BulletQuery>},
      {"fcl_dynamic_aabb", run_peer<FclQuery>}};
  for (const auto& [scene, parts] : scenes) {
    for (const auto& [distance, gap] : gaps) {
      for (const auto& [name, query] : queries) {
        const std::string title = std::string("query/") + scene + '/' + distance + '/' + name;
        benchmark::RegisterBenchmark(title.c_str(),
                                     [make = parts, g = gap, q = query](benchmark::State& state) {
                                       q(state, make_task(make(), g));
                                     });
      }
    }
  }
  return true;
}();

}  // namespace
}  // namespace hapticd::test
