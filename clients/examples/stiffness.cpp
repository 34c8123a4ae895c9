// Presses a finger onto a string and feels it with a softer and softer hand: sets a live parameter
// and watches the force. For a daemon in virtual time with a scripted device:
//   hapticd --clock virtual --device scripted --scene single_string
// usage: stiffness [HOST:PORT]
#include <hapticd/client/session.h>

#include <cstdio>
#include <exception>

using namespace hapticd;

/// Straight down to 3 mm above the string's axis, where a finger of 5 mm presses it, in 200 ticks.
std::vector<client::Pose> press() {
  std::vector<client::Pose> path(200);
  for (std::size_t tick = 0; tick < path.size(); ++tick) {
    path[tick].p_m[1] = 0.0153 - (0.0153 - 0.003) * static_cast<double>(tick) / 199.0;
  }
  return path;
}

int main(int argc, char** argv) try {
  client::SessionOptions options;
  if (argc > 1) options.server = argv[1];
  client::Session session(options);
  session.acquire("stiffness");
  session.load_scene("single_string");
  session.subscribe(1, {v1::SECTION_TOOLS});
  const std::vector<client::Pose> path = press();
  session.run(path.size(), path);
  for (const double kt_n_per_m : {1000.0, 500.0, 250.0}) {
    session.set("tools[0].coupling.kt_n_per_m", kt_n_per_m);
    const v1::State state = session.run(2500).states.back();
    const v1::ToolState& tool = state.tools(0);
    std::printf("%.0f N/m: %.4f N, the finger %.4f mm above the hand\n",
                session.get("tools[0].coupling.kt_n_per_m").number(),
                static_cast<double>(tool.wrench_h_w(1)), (tool.p_wg_m(1) - tool.p_wh_m(1)) * 1e3);
  }
} catch (const std::exception& error) {
  std::fprintf(stderr, "stiffness: %s\n", error.what());
  return 1;
}
