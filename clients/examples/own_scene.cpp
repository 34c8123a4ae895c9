// Loads a scene of its own, a ball above a rod, presses the ball against the rod tick by tick, and
// writes what was felt as CSV. For a daemon in virtual time with a scripted device:
//   hapticd --clock virtual --device scripted
// usage: own_scene [HOST:PORT [FILE.csv]]
#include <hapticd/client/session.h>
#include <hapticd/client/table.h>

#include <algorithm>
#include <cstdio>
#include <exception>

using namespace hapticd;

constexpr const char* kScene = R"(
name: "ball_and_rod"
tools {
  name: "ball"
  parts { name: "ball" shape { spheres { centre_m: [0, 0, 0] radius_m: 0.005 } } }
  pose_wg { p_m: [0, 0.02, 0] }
  coupling { kt_n_per_m: 800 }
}
lines { name: "rod" points_w_m: [-0.1, 0, 0, 0.1, 0, 0] radius_m: 0.005 }
)";

/// From 20 mm above the rod's axis down to 4 mm, a pose for each tick, and 100 ticks there.
std::vector<client::Pose> press() {
  std::vector<client::Pose> path(500);
  for (std::size_t tick = 0; tick < path.size(); ++tick) {
    path[tick].p_m[1] = 0.02 - 0.016 * std::min(1.0, static_cast<double>(tick) / 400.0);
  }
  return path;
}

int main(int argc, char** argv) try {
  client::SessionOptions options;
  if (argc > 1) options.server = argv[1];
  const char* file = argc > 2 ? argv[2] : "own_scene.csv";
  client::Session session(options);
  session.acquire("own_scene");
  session.load_scene(kScene);
  session.subscribe(1, {v1::SECTION_TOOLS});
  const std::vector<client::Pose> path = press();
  const client::RunResult result = session.run(path.size(), path);
  client::write_states(result.states, file);
  for (const v1::Item& event : result.events) {
    if (!event.has_contact()) continue;
    std::printf("the ball touches the rod after %.3f ms\n",
                static_cast<double>(event.contact().t_ns()) * 1e-6);
  }
  std::printf("%zu rows in %s\n", result.states.size(), file);
} catch (const std::exception& error) {
  std::fprintf(stderr, "own_scene: %s\n", error.what());
  return 1;
}
