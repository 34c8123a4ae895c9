// hapticd-oracle poses: what to send to a scripted device so that it follows a gesture. Not RT.
#include <cmath>
#include <memory>

#include "proto/hints/quantity_option.h"
#include "tests/oracle/commands.h"
#include "tests/oracle/gesture_path.h"
#include "tests/oracle/scene_option.h"
#include "tests/oracle/table.h"

namespace hapticd {
namespace {

struct PosesOptions {
  std::string gesture;
  SceneOption scene;
  double rate_hz = 1000.0;
  std::string output;
};

void write_poses(const PosesOptions& options) {
  const std::unique_ptr<LoadedScene> loaded = load_scene(options.scene);
  const SceneDescription& scene = loaded->scene->description();
  const ToolDescription& tool = scene.tools[chosen_tool(options.scene, scene)];
  const GestureMotion motion = load_motion(options.gesture, options.scene.data, scene, tool);
  Table table({"t_s", "x", "y", "z", "qw", "qx", "qy", "qz"});
  for (const TimedPose& at : follow_track(motion.track(), std::llround(1e9 / options.rate_hz))) {
    const Vector3& p = at.X_DH.p;
    const Quaternion& q = at.X_DH.q;
    table << static_cast<double>(at.t_ns) / 1e9 << p.x() << p.y() << p.z();
    table << q.w() << q.x() << q.y() << q.z();
    table.end_row();
  }
  write_output(options.output, table.text());
}

}  // namespace

void add_poses_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "poses", "the path of a gesture from its first way-point on: t_s and X_DH as CSV");
  const auto options = std::make_shared<PosesOptions>();
  command
      ->add_option("GESTURE", options->gesture,
                   "name of an installed gesture, or a .textproto file")
      ->required();
  add_scene_options(*command, options->scene, true);
  hints::takes_unit(command->add_option("--rate", options->rate_hz, "poses per second (1000)")
                        ->check(CLI::Range(1.0, 1e4).description(""))
                        ->type_name("HZ"),
                    "Hz");
  add_output_option(*command, options->output);
  command->callback([options] { write_poses(*options); });
}

}  // namespace hapticd
