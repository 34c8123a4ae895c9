// hapticd-oracle measure: what settings of a scene cost and err, on one seeded gesture. Not RT.
#include <algorithm>
#include <memory>
#include <optional>

#include "proto/hints/quantity_option.h"
#include "tests/oracle/commands.h"
#include "tests/oracle/scene_option.h"
#include "tests/oracle/study_report.h"
#include "tests/oracle/table.h"

namespace hapticd {
namespace {

/// Rate of the truth that other rates of the loop are held against, Hz.
constexpr double kFineRate = 4000.0;
constexpr double kUsualRate = 1000.0;
/// Of the truth about strings: all modes and sub-steps that the core can have.
constexpr int kTruthModes = kMaxModes;
constexpr int kTruthSubsteps = 64;

struct MeasureOptions {
  SceneOption scene;
  std::uint64_t seed = 1;
  double speed = 0.2;
  std::vector<std::string> settings;
  std::vector<std::string> baselines;
  bool judged = true;
  std::string output;
};

/// A scene and a gesture in it, and the truths about it, each computed when it is first asked for.
class Measurement {
 public:
  explicit Measurement(const MeasureOptions& options)
      : options_(options),
        loaded_(load_scene(options.scene)),
        tool_(chosen_tool(options.scene, loaded_->scene->description())),
        judge_(*loaded_->scene, tool_),
        gesture_(
            choose_study_gesture(scene(), tool_, judge_.judge(), options.seed, options.speed)) {}

  [[nodiscard]] const Scene& scene() const { return *loaded_->scene; }

  std::string line(const std::string& text) {
    const std::string other = scene_of_setting(text);
    if (!other.empty()) return other_scene_line(other, text);
    const SceneDescription& description = scene().description();
    const StudySetting setting = parse_setting(text, description);
    const double surface = surface_error(description, tool_, setting.options);
    const std::vector<StudyTick> run =
        setting.changes_strings() ? play_changed(setting) : play(scene(), setting, judge_);
    const bool other_rate = text.find("rate=") != std::string::npos;
    if (setting.changes_strings()) return report(setting.name, run, string_truth(), 1.0, surface);
    if (!other_rate) return report(setting.name, run, truth(), 1.0, surface);
    return report(setting.name, run, fine_truth(), kFineRate / setting.rate_hz, surface);
  }

  std::string baseline_line(const std::string& name) {
    const BaselineMethod method =
        name == "paper" ? BaselineMethod::kPaper : BaselineMethod::kPenalty;
    const double surface =
        surface_error(scene().description(), tool_, scene().description().contact);
    return report(name, play_baseline(scene(), tool_, method, gesture_, judge_.judge()), truth(),
                  1.0, surface);
  }

 private:
  [[nodiscard]] std::vector<StudyTick> play(const Scene& scene, const StudySetting& setting,
                                            PathRun& judge) const {
    return play_study(scene, tool_, setting, gesture_,
                      options_.judged && setting.judged ? &judge : nullptr);
  }

  [[nodiscard]] std::vector<StudyTick> play_changed(const StudySetting& setting) const {
    const Scene changed(with_strings(scene().description(), setting));
    PathRun judge(changed, tool_);
    return play(changed, setting, judge);
  }

  /// The gesture of this scene in another one, against the truth of this one.
  std::string other_scene_line(const std::string& name, const std::string& text) {
    SceneOption option = options_.scene;
    option.scene = name;
    const std::unique_ptr<LoadedScene> other = load_scene(option);
    const SceneDescription& description = other->scene->description();
    const StudySetting setting = parse_setting(text, description);
    PathRun judge(*other->scene, tool_);
    return report(setting.name, play(*other->scene, setting, judge), truth(), 1.0,
                  surface_error(description, tool_, setting.options));
  }

  using Truth = std::optional<std::vector<StudyTick>>;

  static std::string report(const std::string& name, const std::vector<StudyTick>& run,
                            const std::vector<StudyTick>& truth, double per_tick, double surface) {
    return study_line(name, run, compare(run, truth, per_tick), surface);
  }

  [[nodiscard]] StudySetting truth_setting(double rate_hz) const {
    StudySetting setting;
    setting.rate_hz = rate_hz;
    setting.options = truth_options(scene().description());
    return setting;
  }

  const std::vector<StudyTick>& truth() {
    if (!truth_) truth_ = play_study(scene(), tool_, truth_setting(kUsualRate), gesture_, nullptr);
    return *truth_;
  }

  const std::vector<StudyTick>& fine_truth() {
    if (!fine_) fine_ = play_study(scene(), tool_, truth_setting(kFineRate), gesture_, nullptr);
    return *fine_;
  }

  const std::vector<StudyTick>& string_truth() {
    if (!strings_) {
      StudySetting setting = truth_setting(kUsualRate);
      setting.string_model = StringContact::kYielding;
      setting.string_level = StringDetail::kModes;
      setting.modes = kTruthModes;
      setting.substeps = kTruthSubsteps;
      const Scene exact(with_strings(scene().description(), setting));
      strings_ = play_study(exact, tool_, setting, gesture_, nullptr);
    }
    return *strings_;
  }

  MeasureOptions options_;
  std::unique_ptr<LoadedScene> loaded_;
  std::size_t tool_;
  PathRun judge_;
  StudyGesture gesture_;
  Truth truth_, fine_, strings_;
};

void measure(const MeasureOptions& options) {
  Measurement measurement(options);
  std::string text;
  for (const std::string& setting : options.settings) text += measurement.line(setting) + "\n";
  for (const std::string& name : options.baselines) text += measurement.baseline_line(name) + "\n";
  write_output(options.output, text);
}

}  // namespace

void add_measure_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "measure",
      "what settings of a scene cost and err on a gesture drawn by a seed: a line of JSON for each "
      "setting, against 400 sub-steps of the same input; ways are judged by exhaustive search");
  const auto options = std::make_shared<MeasureOptions>();
  add_scene_options(*command, options->scene, true);
  command->add_option("--seed", options->seed, "of the gesture (1)")->type_name("NUMBER");
  hints::takes_unit(
      command->add_option("--speed", options->speed, "peak speed along the surface, m/s (0.2)")
          ->check(CLI::Range(1e-3, 100.0).description(""))
          ->type_name("M/S"),
      "m/s");
  command
      ->add_option("--setting", options->settings,
                   "what is measured, as in usual: or few:sub_steps=2,margin=0.001 or fast:level=0 "
                   "(default: usual:); may be repeated")
      ->type_name("NAME:KEY=VALUE,...");
  command
      ->add_option("--baseline", options->baselines,
                   "another method on the same gesture: paper, penalty; may be repeated")
      ->check(CLI::Validator(CLI::IsMember({"paper", "penalty"})).description(""))
      ->type_name("paper|penalty");
  command->add_flag("!--unjudged", options->judged,
                    "leave out the exhaustive search of every way, which takes most of the time");
  add_output_option(*command, options->output);
  command->callback([options] {
    if (options->settings.empty() && options->baselines.empty()) options->settings = {"usual:"};
    measure(*options);
  });
}

}  // namespace hapticd
