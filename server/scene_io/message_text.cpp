// See message_text.h.
#include "server/scene_io/message_text.h"

#include <google/protobuf/io/tokenizer.h>
#include <google/protobuf/io/zero_copy_stream_impl_lite.h>

#include <charconv>

#include "proto/hints/text_remedy.h"

namespace hapticd {
namespace {

namespace pb = google::protobuf;

/// Deepest nesting of messages accepted; a scene has six levels.
constexpr int kDeepestNesting = 32;
/// Most errors of one text that are reported.
constexpr std::size_t kMaxErrors = 20;

class Collector : public pb::io::ErrorCollector {
 public:
  Collector(const std::string& file, const pb::Descriptor& type, SceneProblems& problems)
      : file_(file), type_(type), problems_(problems) {}
  void AddError(int line, pb::io::ColumnNumber column, const std::string& message) override {
    add(line, column, message, false);
  }
  void AddWarning(int line, pb::io::ColumnNumber column, const std::string& message) override {
    add(line, column, message, true);
  }

 private:
  void add(int line, int column, const std::string& message, bool doubt) {
    if (problems_.size() >= kMaxErrors) return;
    problems_.push_back(
        {doubt, file_, line + 1, column + 1, "", message, hints::text_remedy(type_, message)});
  }

  const std::string& file_;
  const pb::Descriptor& type_;
  SceneProblems& problems_;
};

/// One step of a path: "strings[3]" is the field strings with index 3.
struct PathStep {
  std::string_view name;
  int index = -1;
};

/// Takes the first step off `path`.
PathStep take_step(std::string_view& path) {
  const std::size_t dot = path.find('.');
  std::string_view step = path.substr(0, dot);
  path = dot == std::string_view::npos ? std::string_view() : path.substr(dot + 1);
  const std::size_t bracket = step.find('[');
  if (bracket == std::string_view::npos) return {step, -1};
  PathStep result{step.substr(0, bracket), 0};
  step.remove_prefix(bracket + 1);
  std::from_chars(step.data(), step.data() + step.size(), result.index);
  return result;
}

}  // namespace

MessageText::MessageText(std::string_view text, std::string file, std::string_view what,
                         pb::Message& message)
    : file_(std::move(file)), type_(message.GetDescriptor()) {
  if (text.size() > kMaxText) {
    problems_.push_back({false, file_, 0, 0, "",
                         "the text of " + std::to_string(text.size()) + " bytes is longer than " +
                             std::to_string(kMaxText),
                         what == "scene" ? "Put spheres into tree files." : ""});
    return;
  }
  Collector collector(file_, *type_, problems_);
  pb::TextFormat::Parser parser;
  parser.RecordErrorsTo(&collector);
  parser.WriteLocationsTo(&places_);
  parser.SetRecursionLimit(kDeepestNesting);
  pb::io::ArrayInputStream stream(text.data(), static_cast<int>(text.size()));
  if (!parser.Parse(&stream, &message) && problems_.empty()) {
    problems_.push_back({false, file_, 0, 0, "",
                         "this is not a " + std::string(what) + " in protobuf text format", ""});
  }
}

SceneProblem MessageText::located(SceneProblem problem) const {
  problem.file = file_;
  const pb::Descriptor* message = type_;
  const pb::TextFormat::ParseInfoTree* places = &places_;
  std::string_view path = problem.field;
  while (!path.empty() && message != nullptr && places != nullptr) {
    const PathStep step = take_step(path);
    const pb::FieldDescriptor* field = message->FindFieldByName(std::string(step.name));
    if (field == nullptr) break;
    const int index = field->is_repeated() ? std::max(step.index, 0) : -1;
    const auto place = places->GetLocation(field, index);
    if (place.line >= 0) {
      problem.line = place.line + 1;
      problem.column = place.column + 1;
    }
    message = field->message_type();
    places = message == nullptr ? nullptr : places->GetTreeForNested(field, index);
  }
  return problem;
}

}  // namespace hapticd
