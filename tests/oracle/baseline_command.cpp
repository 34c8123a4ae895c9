// hapticd-oracle baseline: the paper as printed, or a penalty method, on the same poses. Not RT.
#include <algorithm>
#include <array>
#include <memory>
#include <optional>

#include "tests/oracle/baseline.h"
#include "tests/oracle/commands.h"
#include "tests/oracle/pop_through.h"
#include "tests/oracle/pose_stream.h"
#include "tests/oracle/scene_objects.h"
#include "tests/oracle/table.h"

namespace hapticd {
namespace {

struct BaselineCommand {
  std::string method;
  std::string recording;
  std::string poses;
  std::string tank = "off";
  std::string breathing = "released";
  SceneOption scene;
  std::optional<std::uint32_t> scene_id;
  BaselineOptions options;
  std::string output;
};

/// Names of the objects that are strings or lines.
std::vector<std::string> capsule_objects(const SceneObjects& objects) {
  const std::size_t count = objects.names.size() - objects.of_body.size();
  std::vector<std::string> names;
  names.reserve(count);
  for (std::size_t k = 0; k < count; ++k) {
    names.push_back("popped_" + objects.names[k]);
  }
  return names;
}

/// What is measured along the stream, and the table it goes into.
class Measurement {
 public:
  Measurement(const Scene& scene, const ToolScene& tool, const BaselineOptions& options)
      : objects_(scene_objects(scene)),
        baseline_(tool, options),
        judge_(tool),
        watch_(tool),
        table_(columns(objects_)) {}

  void tick(const ToolScene& tool, const StreamedPose& pose) {
    const BaselineTick now = baseline_.tick(tool, pose.X_WH, pose.dt_s);
    if (!before_) {
      before_ = now;
      X_WH_ = pose.X_WH;
    }
    // The wrench of the last tick has acted until now.
    const ToolMotion way = motion_between(X_WH_, pose.X_WH);
    given_j_ += before_->F_H_W.f.dot(way.dp) + before_->F_H_W.t.dot(way.dtheta);
    path_[0].X_WG = before_->X_WG;
    path_[1].X_WG = now.X_WG;
    const std::vector<bool> popped = watch_.go(before_->X_WG, now.X_WG);
    table_ << pose.tick << pose.t_s;
    write(now.F_H_W.f);
    write(now.F_H_W.t);
    write(now.X_WG.p);
    const Quaternion& q = now.X_WG.q;
    table_ << q.w() << q.x() << q.y() << q.z();
    table_ << judge_.smallest_gap(path_) << (now.F_H_W.f - before_->F_H_W.f).norm();
    table_ << now.repulsion << now.vibration << now.deflection << now.radius_growth << given_j_;
    table_ << std::uint64_t{now.pairs} << std::uint64_t{now.solved};
    for (std::size_t k = 0; k < objects_.names.size() - objects_.of_body.size(); ++k) {
      bool any = false;
      for (std::size_t c = 0; c < popped.size(); ++c) {
        any = any || (popped[c] && objects_.of_capsule[c] == k);
      }
      table_ << std::uint64_t{any};
    }
    table_.end_row();
    before_ = now;
    X_WH_ = pose.X_WH;
  }

  [[nodiscard]] const std::string& text() const noexcept { return table_.text(); }

 private:
  static std::vector<std::string> columns(const SceneObjects& objects) {
    std::vector<std::string> names{
        "tick",         "t_s",          "force_x_n", "force_y_n",  "force_z_n",    "torque_x_n_m",
        "torque_y_n_m", "torque_z_n_m", "p_wg_x_m",  "p_wg_y_m",   "p_wg_z_m",     "q_wg_w",
        "q_wg_x",       "q_wg_y",       "q_wg_z",    "path_gap_m", "force_jump_n", "f_r_n",
        "f_v_n",        "delta_m",      "radius_m",  "port_j",     "pairs",        "solved"};
    const std::vector<std::string> popped = capsule_objects(objects);
    names.insert(names.end(), popped.begin(), popped.end());
    return names;
  }

  void write(const Vector3& v) { table_ << v.x() << v.y() << v.z(); }

  SceneObjects objects_;
  Baseline baseline_;
  PathJudge judge_;
  PopThroughWatch watch_;
  Table table_;
  std::optional<BaselineTick> before_;
  std::array<ContactState, 2> path_;
  Pose X_WH_;
  double given_j_ = 0.0;  ///< to the hand so far
};

void run_baseline(BaselineCommand command) {
  const bool table = !command.poses.empty() || !command.scene.scene.empty();
  if (table == !command.recording.empty() || command.poses.empty() != command.scene.scene.empty()) {
    throw std::invalid_argument("give a RECORDING, or --scene and --poses together");
  }
  command.options.method =
      command.method == "paper" ? BaselineMethod::kPaper : BaselineMethod::kPenalty;
  command.options.vibration.tank = command.tank == "on";
  command.options.breathing = command.breathing == "none"       ? Breathing::kNone
                              : command.breathing == "released" ? Breathing::kReleased
                                                                : Breathing::kAlways;
  std::optional<Measurement> measurement;
  const StreamVisitor visitor{
      [&](const Scene& scene, const ToolScene& tool) {
        measurement.emplace(scene, tool, command.options);
      },
      [&](const ToolScene& tool, const StreamedPose& pose) { measurement->tick(tool, pose); }};
  if (table) {
    stream_table(command.scene, command.poses, visitor);
  } else {
    stream_recording(
        {command.recording, command.scene.data, command.scene_id, command.scene.tool_id}, visitor);
  }
  write_output(command.output, measurement->text());
}

void add_choice(CLI::App& app, const std::string& name, std::string& value,
                const std::vector<std::string>& choices, const std::string& help) {
  std::string names;
  for (const std::string& choice : choices) names += (names.empty() ? "" : "|") + choice;
  app.add_option(name, value, help)
      ->check(CLI::Validator(CLI::IsMember(choices)).description(""))
      ->type_name(names);
}

}  // namespace

void add_baseline_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "baseline",
      "another method on the same poses, for comparison: the paper as printed, or a penalty on "
      "every sphere; force, path and pop-through per tick as CSV");
  const auto options = std::make_shared<BaselineCommand>();
  command->add_option("RECORDING", options->recording, "file that hapticd --record wrote");
  add_choice(*command, "--method", options->method, {"paper", "penalty"}, "what is computed");
  command->get_option("--method")->required();
  command
      ->add_option("--poses", options->poses,
                   "table of X_DH as 'hapticd-oracle poses' writes it, instead of a recording")
      ->type_name("CSV");
  add_scene_options(*command, options->scene, false);
  command
      ->add_option("--scene-id", options->scene_id,
                   "of a recording: number of the load (default: the first that has any tick)")
      ->type_name("ID");
  add_choice(*command, "--tank", options->tank, {"on", "off"},
             "paper: bound the vibration force by an energy tank (off)");
  add_choice(
      *command, "--breathing", options->breathing, {"none", "released", "always"},
      "paper: what the collision radius follows: nothing, what rings, or the touch too (released)");
  command
      ->add_option("--lambda-margin", options->options.lambda_margin,
                   "paper: how far beyond its ends a string is felt, in lengths (0.005)")
      ->check(CLI::Range(0.0, 1.0).description(""))
      ->type_name("SHARE");
  add_output_option(*command, options->output);
  command->callback([options] { run_baseline(*options); });
}

}  // namespace hapticd
