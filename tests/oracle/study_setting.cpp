// See study_setting.h.
#include "tests/oracle/study_setting.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "core/instrument/mode_series.h"
#include "core/scene/quality.h"
#include "core/scene/scene_settings.h"
#include "proto/hints/nearest_name.h"
#include "proto/hints/quantity.h"

namespace hapticd {
namespace {

/// Names of choices.
const std::map<std::string, bool> kAnswers{{"yes", true}, {"no", false}};
const std::map<std::string, StringContact> kModels{{"rigid", StringContact::kStraight},
                                                   {"deflecting", StringContact::kYielding}};
const std::map<std::string, StringDetail> kLevels{{"static", StringDetail::kStatic},
                                                  {"fundamental", StringDetail::kFundamental},
                                                  {"modes", StringDetail::kModes}};
const std::map<std::string, int> kSubsteps{{"8", 8}, {"16", 16}, {"32", 32}, {"64", 64}};

[[noreturn]] void refuse(const std::string& text, const std::string& why) {
  throw std::invalid_argument("--setting " + text + ": " + why);
}

/// What a number may be.
struct Range {
  double least;
  double most;
  const char* unit = "";
};

/// A number in the range, in its unit or one of its kind.
double number(const std::string& text, const std::string& value, const Range& range) {
  const hints::Quantity said = hints::parse_quantity(value, range.unit);
  if (!said.fault.empty()) refuse(text, said.fault);
  if (said.value < range.least || said.value > range.most) {
    std::ostringstream why;
    why << value << " is not a number from " << range.least << " to " << range.most << range.unit;
    refuse(text, why.str());
  }
  return said.value;
}

int whole(const std::string& text, const std::string& value, int least, int most) {
  return static_cast<int>(
      std::lround(number(text, value, {static_cast<double>(least), static_cast<double>(most)})));
}

template <typename Value>
Value named(const std::string& text, const std::string& value,
            const std::map<std::string, Value>& choices) {
  const auto found = choices.find(value);
  if (found != choices.end()) return found->second;
  std::string known;
  for (const auto& choice : choices) known += " " + choice.first;
  refuse(text, value + " is none of:" + known);
}

void take_level(int level, const SceneDescription& scene, StudySetting& setting) {
  LiveSettings live = scene_settings(scene).tools.front();
  set_level(level, live);
  setting.options = live.contact;
}

/// Puts KEY=VALUE into the setting. Ranges are those of scene.proto.
void assign(const std::string& text, const std::string& key, const std::string& value,
            const SceneDescription& scene, StudySetting& setting) {
  ContactOptions& o = setting.options;
  const auto real = [&](double& into, const Range& range) {
    return [&, range] { into = number(text, value, range); };
  };
  const auto count = [&](int& into, int least, int most) {
    return [&, least, most] { into = whole(text, value, least, most); };
  };
  const std::map<std::string, std::function<void()>> keys{
      {"scene", [&] { setting.scene = value; }},
      {"level", [&] { take_level(whole(text, value, 0, kQualityLevels - 1), scene, setting); }},
      {"sub_steps", count(o.sub_steps, 1, 4096)},
      {"stop_tolerance", real(o.stop_tolerance, {1e-15, 1e-3})},
      {"margin", real(o.margin, {1e-6, 1.0, "m"})},
      {"rotation_step", real(o.rotation_step, {1e-6, 1.0, "rad"})},
      {"max_rows", count(o.max_rows, 1, kMaxQpRows)},
      {"tool_level", count(o.tool_level, 1, kMaxTreeDepth)},
      {"body_level", count(o.body_level, 1, kMaxTreeDepth)},
      {"judged", [&] { setting.judged = named(text, value, kAnswers); }},
      {"rate", real(setting.rate_hz, {50.0, 8000.0, "Hz"})},
      {"string", [&] { setting.string_model = named(text, value, kModels); }},
      {"string_level", [&] { setting.string_level = named(text, value, kLevels); }},
      {"modes", [&] { setting.modes = whole(text, value, 0, kMaxModes); }},
      {"wave_substeps", [&] { setting.substeps = named(text, value, kSubsteps); }}};
  const auto found = keys.find(key);
  if (found == keys.end()) {
    std::string known;
    std::vector<std::string> names;
    names.reserve(keys.size());
    for (const auto& each : keys) names.push_back(each.first);
    for (const std::string& name : names) known += " " + name;
    refuse(text,
           "there is no " + key + "; there are:" + known + "." + hints::did_you_mean(key, names));
  }
  found->second();
}

}  // namespace

StudySetting parse_setting(const std::string& text, const SceneDescription& scene) {
  StudySetting setting;
  setting.options = scene.contact;
  const std::size_t colon = text.find(':');
  setting.name = text.substr(0, colon);
  if (setting.name.empty()) refuse(text, "give it a name, as in few:sub_steps=2");
  if (colon == std::string::npos) return setting;
  // The level first, wherever it is: the others change what it decides.
  for (const bool levels : {true, false}) {
    std::istringstream rest(text.substr(colon + 1));
    std::string each;
    while (std::getline(rest, each, ',')) {
      const std::size_t equals = each.find('=');
      if (equals == std::string::npos) refuse(text, each + " is not KEY=VALUE");
      const std::string key = each.substr(0, equals);
      if ((key == "level") == levels) assign(text, key, each.substr(equals + 1), scene, setting);
    }
  }
  return setting;
}

std::string scene_of_setting(const std::string& text) {
  std::istringstream rest(text.substr(std::min(text.size(), text.find(':') + 1)));
  std::string each;
  while (std::getline(rest, each, ',')) {
    if (each.rfind("scene=", 0) == 0) return each.substr(6);
  }
  return "";
}

ContactOptions truth_options(const SceneDescription& scene) {
  ContactOptions options = scene.contact;
  options.sub_steps = 400;
  options.rotation_step = 4e-3;
  options.stop_tolerance = 1e-10;
  options.max_rows = kMaxQpRows;
  options.tool_level = kLeafLevel;
  options.body_level = kLeafLevel;
  return options;
}

SceneDescription with_strings(SceneDescription scene, const StudySetting& setting) {
  for (StringDescription& string : scene.strings) {
    if (setting.string_model) string.parameters.model = *setting.string_model;
    if (setting.string_level) string.parameters.max_level = *setting.string_level;
  }
  if (setting.modes) scene.instrument.modes = *setting.modes;
  if (setting.substeps) scene.instrument.substeps = *setting.substeps;
  return scene;
}

}  // namespace hapticd
