// See scene_parameters.h.
#include "server/scene_io/scene_parameters.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <functional>
#include <map>
#include <regex>
#include <string_view>
#include <system_error>

#include "proto/hints/nearest_name.h"
#include "proto/wire/field_table.h"
#include "server/scene_io/scene_defaults.h"

namespace hapticd {
namespace {

namespace pb = google::protobuf;
using Kind = pb::FieldDescriptor::CppType;

/// The path `quality` means the choice.
constexpr const char* kQuality = "quality";

/// A live field, or one number of several.
struct LiveField {
  const pb::Message& message;
  const pb::FieldDescriptor& field;
  const wire::FieldRow& row;
  int index;  ///< of the number
};

using Visit = std::function<void(const LiveField&, const std::string& path)>;

/// Calls `visit` for every live field that is there.
// NOLINTNEXTLINE(misc-no-recursion): as deep as the schema, which does not contain itself
void walk(const pb::Message& message, const std::string& path, const Visit& visit) {
  const pb::Descriptor& type = *message.GetDescriptor();
  const pb::Reflection& r = *message.GetReflection();
  for (int i = 0; i < type.field_count(); ++i) {
    const pb::FieldDescriptor& field = *type.field(i);
    if (field.has_presence() && !r.HasField(message, &field)) continue;
    const std::string here = path.empty() ? field.name() : path + "." + field.name();
    const wire::FieldRow* row = wire::find_row(type.name() + "." + field.name());
    if (row != nullptr && row->live && field.is_repeated()) {
      for (int k = 0; k < r.FieldSize(message, &field); ++k) {
        visit({message, field, *row, k}, here + "[" + std::to_string(k) + "]");
      }
    } else if (row != nullptr && row->live) {
      visit({message, field, *row, 0}, here);
    } else if (field.cpp_type() == Kind::CPPTYPE_MESSAGE && field.is_repeated()) {
      for (int k = 0; k < r.FieldSize(message, &field); ++k) {
        walk(r.GetRepeatedMessage(message, &field, k), here + "[" + std::to_string(k) + "]", visit);
      }
    } else if (field.cpp_type() == Kind::CPPTYPE_MESSAGE) {
      walk(r.GetMessage(message, &field), here, visit);
    }
  }
}

/// strings.3.tension_n -> strings[3].tension_n, which is how indices are written.
std::string bracketed(const std::string& path) {
  static const std::regex dotted(R"(\.([0-9]+)(?=\.|\[|$))");
  return std::regex_replace(path, dotted, "[$1]");
}

/// strings[3].tension_n -> strings[*].tension_n
std::string any_index(const std::string& path) {
  std::string out;
  bool inside = false;
  for (const char c : path) {
    if (c == '[') out += "[*";
    if (c == ']') inside = false;
    if (!inside && c != '[') out += c;
    if (c == '[') inside = true;
  }
  return out;
}

/// `pattern` with the indices that `path` has, in order; 0 where it has none.
std::string with_indices_of(const std::string& path, const std::string& pattern) {
  std::string out;
  std::size_t from = 0;
  std::size_t open = 0;
  for (std::size_t star = pattern.find("[*]"); star != std::string::npos;
       star = pattern.find("[*]", from)) {
    open = path.find('[', open);
    const std::size_t close = open == std::string::npos ? open : path.find(']', open);
    const bool found = close != std::string::npos;
    out += pattern.substr(from, star - from);
    out += found ? path.substr(open, close + 1 - open) : "[0]";
    open = close;
    from = star + 3;
  }
  return out + pattern.substr(from);
}

void put_value(const LiveField& live, v1::Assignment& out) {
  const auto& [message, field, row, index] = live;
  const pb::Reflection& r = *message.GetReflection();
  if (field.is_repeated()) {
    out.set_number(r.GetRepeatedDouble(message, &field, index));
  } else if (field.cpp_type() == Kind::CPPTYPE_MESSAGE) {
    const auto& pose = dynamic_cast<const v1::Pose&>(r.GetMessage(message, &field));
    for (const double p : pose.p_m()) out.mutable_numbers()->add_values(p);
    for (const double q : pose.q()) out.mutable_numbers()->add_values(q);
  } else if (field.cpp_type() == Kind::CPPTYPE_ENUM) {
    out.set_text(r.GetEnum(message, &field)->name());
  } else if (field.cpp_type() == Kind::CPPTYPE_DOUBLE) {
    out.set_number(r.GetDouble(message, &field));
  } else {
    out.set_number(r.GetUInt32(message, &field));
  }
}

/// The one of `patterns` whose last field begins with `word`, where there is one only.
std::string field_of(const std::string& word, const std::vector<std::string>& patterns) {
  std::string found;
  for (const std::string& pattern : patterns) {
    const std::size_t dot = pattern.rfind('.');
    if (word.empty() || !pattern.substr(dot == std::string::npos ? 0 : dot + 1).starts_with(word)) {
      continue;
    }
    if (!found.empty()) return {};
    found = pattern;
  }
  return found;
}

/// What to write for the first index of `path`, whose names are right, that is none; for a field
/// that this one of several lacks, that it does.
std::string index_remedy(const v1::Scene& scene, std::string_view path) {
  const std::string lacking = "The scene has none with this index.";
  const pb::Message* message = &scene;
  while (true) {
    const std::string_view step = path.substr(0, path.find('.'));
    const std::size_t bracket = step.find('[');
    const std::string name(step.substr(0, bracket));
    const pb::FieldDescriptor* const field = message->GetDescriptor()->FindFieldByName(name);
    if (field == nullptr) return lacking;
    const pb::Reflection& r = *message->GetReflection();
    int index = 0;
    if (field->is_repeated()) {
      const int size = r.FieldSize(*message, field);
      if (size == 0) return "The scene has no " + name + ".";
      const char* const end = step.data() + step.size();
      const char* const begin = step.data() + std::min(bracket, step.size() - 1) + 1;
      const auto [stop, error] = std::from_chars(begin, end, index);
      const bool whole = error == std::errc() && stop + 1 == end && *stop == ']';
      if (!whole || index < 0 || index >= size) {
        return "The index of " + name + " is a whole number" +
               (size == 1 ? ": 0." : ", 0 to " + std::to_string(size - 1) + ".");
      }
    }
    if (step.size() == path.size() || field->cpp_type() != Kind::CPPTYPE_MESSAGE) return lacking;
    path.remove_prefix(step.size() + 1);
    message = field->is_repeated() ? &r.GetRepeatedMessage(*message, field, index)
                                   : &r.GetMessage(*message, field);
  }
}

/// The choice of quality, which has its own path.
v1::Assignment quality_value(const v1::Scene& scene) {
  v1::Assignment value;
  value.set_path(kQuality);
  if (scene.quality().has_automatic()) {
    value.set_text("auto");
  } else {
    value.set_number(quality_level(scene.quality()));
  }
  return value;
}

}  // namespace

std::vector<v1::ParameterInfo> live_parameters(const v1::Scene& scene) {
  std::vector<v1::ParameterInfo> parameters;
  walk(scene, "", [&](const LiveField& live, const std::string& path) {
    const wire::FieldRow& row = live.row;
    const std::string any = any_index(path);
    const auto same = [&](const v1::ParameterInfo& p) { return p.path() == any; };
    if (std::any_of(parameters.begin(), parameters.end(), same)) return;
    v1::ParameterInfo& info = parameters.emplace_back();
    info.set_path(any);
    info.set_unit(std::string(row.unit));
    const auto range = wire::parse_interval(row.range);
    if (!range) return;
    if (std::isfinite(range->low)) info.set_minimum(range->low);
    if (std::isfinite(range->high)) info.set_maximum(range->high);
  });
  v1::ParameterInfo& quality = parameters.emplace_back();
  quality.set_path(kQuality);
  quality.set_unit("level");
  quality.set_minimum(0);
  quality.set_maximum(4);
  return parameters;
}

ParameterReading parameter_values(const v1::Scene& scene, const std::vector<std::string>& paths) {
  std::vector<v1::Assignment> all;
  walk(scene, "", [&](const LiveField& live, const std::string& path) {
    v1::Assignment& value = all.emplace_back();
    value.set_path(path);
    put_value(live, value);
  });
  all.push_back(quality_value(scene));
  if (paths.empty()) return {std::move(all), std::nullopt};
  // Once through the values, of which there may be thousands.
  std::map<std::string, std::vector<std::size_t>, std::less<>> found;
  for (const std::string& path : paths) found[path];
  const auto note = [&](const std::string& path, std::size_t k) {
    if (const auto asked = found.find(path); asked != found.end()) asked->second.push_back(k);
  };
  for (std::size_t k = 0; k < all.size(); ++k) {
    const std::string any = any_index(all[k].path());
    note(all[k].path(), k);
    if (any != all[k].path()) note(any, k);
  }
  ParameterReading reading;
  for (const std::string& path : paths) {
    const std::vector<std::size_t>& which = found[path];
    if (which.empty()) return {{}, path};
    for (const std::size_t k : which) reading.values.push_back(all[k]);
  }
  return reading;
}

std::string unknown_parameter(const v1::Scene& scene, const std::string& given) {
  const std::string path = bracketed(given);
  std::vector<std::string> patterns;
  for (const v1::ParameterInfo& info : live_parameters(scene)) patterns.push_back(info.path());
  const std::string any = any_index(path);
  if (std::find(patterns.begin(), patterns.end(), path) != patterns.end()) {
    return "Give an index in place of *.";
  }
  const bool exists = std::find(patterns.begin(), patterns.end(), any) != patterns.end();
  if (exists && path == given) {
    return index_remedy(scene, path);
  }
  std::string text = "No live parameter has this path; hapticctl get lists them.";
  std::string nearest = hints::nearest_name(any, patterns);
  if (nearest.empty()) nearest = field_of(any, patterns);
  if (nearest.empty()) return text;
  const std::string meant = with_indices_of(path, nearest);
  const bool is_there = !parameter_values(scene, {meant}).unknown.has_value();
  return text + " Did you mean " + (is_there ? meant : with_indices_of("", nearest)) + "?";
}

}  // namespace hapticd
