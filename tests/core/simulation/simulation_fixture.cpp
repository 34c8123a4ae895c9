// See simulation_fixture.h.
#include "tests/core/simulation/simulation_fixture.h"

#include <algorithm>
#include <iterator>

namespace hapticd::test {
namespace {

/// `preset` with friction.
Preset rubbing(Preset preset, const char* name) {
  preset.name = name;
  preset.options.friction = true;
  preset.string.friction_coefficient = 0.3;
  return preset;
}

}  // namespace

Instrument::Instrument(int count, const StringParameters& prototype,
                       const InstrumentOptions& options, std::vector<Sphere> spheres)
    : tree_(build_sphere_tree(spheres)) {
  for (int i = 0; i < count; ++i) {
    StringParameters string = prototype;
    string.p_WA = {0.0, 0.0, 0.02 * i};
    string.p_WB = {1.1, 0.0, 0.02 * i};
    if (string.frequency == 0.0 && string.linear_density == 0.0) {
      string.frequency = kTuning[static_cast<std::size_t>(i) % std::size(kTuning)];
    }
    capsules_W.push_back({to_vector(string.p_WA), to_vector(string.p_WB), string.radius});
    strings.push_back(derive_string(string));
  }
  ToolScene scene;
  scene.tool = tree_.view();
  scene.obstacles.capsules_W = capsules_W;
  for (std::size_t i = 0; kCapsulesPerGroup * i < capsules_W.size(); ++i) {
    groups.push_back(group_capsules(capsules_W, i));
  }
  scene.obstacles.groups = groups;
  scene.obstacles.all = box_of(groups);
  scene.strings = strings;
  scene.instrument = options;
  simulation_ = own_simulation({&scene, 1});
}

const SimulationTick& Instrument::tick(const Pose& X_WH) {
  t_ns += dt_ns;
  p_WH = X_WH.p;
  return tick_sample(HandPose{t_ns, to_array(X_WH.p), to_array(X_WH.q)});
}

const SimulationTick& Instrument::tick_sample(const HandPose& sample) {
  verdict_ = guarded_step(sample, hand_, simulation(), output_);
  events.insert(events.end(), output_.events().begin(), output_.events().end());
  return output_;
}

const StringTick* Instrument::reading(int string) const {
  for (const StringTick& reading : output_.strings()) {
    if (reading.string == string) return &reading;
  }
  return nullptr;
}

double Instrument::energy(int string) const {
  if (const StringTick* ringing = reading(string)) return ringing->energy;
  return state(string).vibration.energy;
}

double Instrument::normal_force(int string) const {
  const StringTick* vibrating = reading(string);
  double force = vibrating != nullptr ? vibrating->vibration_force : 0.0;
  for (const PressedString& contact : output_.tool(0).strings) {
    if (contact.string == string) force += contact.force;
  }
  return force;
}

int count(const std::vector<StringEvent>& events, StringEventKind kind) {
  return static_cast<int>(std::count_if(events.begin(), events.end(),
                                        [&](const StringEvent& e) { return e.kind == kind; }));
}

std::vector<StringEvent> of_kind(const std::vector<StringEvent>& events, StringEventKind kind) {
  std::vector<StringEvent> found;
  std::copy_if(events.begin(), events.end(), std::back_inserter(found),
               [&](const StringEvent& e) { return e.kind == kind; });
  return found;
}

Preset paper_preset() {
  Preset preset{"paper", {}, {}};
  preset.string.model = StringContact::kStraight;
  preset.string.touch_decay = preset.string.decay;
  preset.options.tones.level = ToneLevel::kForce;
  return preset;
}

Preset deflecting_preset() { return {"deflecting", {}, {}}; }

Preset sounding_preset() {
  Preset preset = deflecting_preset();
  preset.name = "sounding";
  preset.options.modes = 16;
  return preset;
}

std::vector<Preset> all_presets() {
  std::vector<Preset> presets = fundamental_presets();
  presets.push_back(sounding_preset());
  presets.push_back(rubbing(sounding_preset(), "sounding, friction"));
  return presets;
}

std::vector<Preset> fundamental_presets() {
  return {paper_preset(), rubbing(paper_preset(), "paper, friction"), deflecting_preset(),
          rubbing(deflecting_preset(), "deflecting, friction")};
}

int count_played(const std::vector<StringEvent>& events) {
  return static_cast<int>(events.size()) - count(events, StringEventKind::kRadius) -
         count(events, StringEventKind::kSounding);
}

double felt_distance(const Instrument& instrument) {
  return kFingertip + instrument.capsules_W.front().r;
}

}  // namespace hapticd::test
