// See hapticd/client/session.h and error.h.
#include <hapticd/client/session.h>

#include <google/protobuf/io/tokenizer.h>
#include <google/protobuf/text_format.h>

#include <utility>

#include "clients/sdk/assignment.h"
#include "clients/sdk/session_stream.h"

namespace hapticd::client {
namespace {

/// A scene or gesture itself, and no name: names have neither braces nor line breaks.
bool is_text(const std::string& source) { return source.find_first_of("{\n") != std::string::npos; }

/// The first thing that is wrong with a text.
class FirstError : public google::protobuf::io::ErrorCollector {
 public:
  void AddError(int line, int column, const std::string& message) override {
    if (!text_.empty()) return;
    text_ = "line " + std::to_string(line + 1) + ", column " + std::to_string(column + 1) + ": " +
            message;
  }
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  std::string text_;
};

v1::Gesture gesture_of(const std::string& text) {
  FirstError error;
  google::protobuf::TextFormat::Parser parser;
  parser.RecordErrorsTo(&error);
  v1::Gesture gesture;
  if (parser.ParseFromString(text, &gesture)) return gesture;
  throw Error(v1::RESULT_CODE_INVALID, "gesture", "the gesture, " + error.text());
}

void check_messages(std::uint64_t messages) {
  if (messages == kMessages) return;
  throw Error(v1::RESULT_CODE_UNSUPPORTED, "",
              "this program was compiled with the messages of another version of hapticd than that "
              "of its library. Build it anew.");
}

}  // namespace

inline namespace abi_0 {

const char* library_version() noexcept { return HAPTICD_VERSION; }

Error::Error(v1::ResultCode code, std::string path, const std::string& message)
    : std::runtime_error(message), code_(code), path_(std::move(path)) {}
Error::~Error() = default;
v1::ResultCode Error::code() const noexcept { return code_; }
const std::string& Error::path() const noexcept { return path_; }

Session::Session(const SessionOptions& options, std::uint64_t messages)
    : stream_((check_messages(messages), std::make_unique<SessionStream>(options))) {}
Session::~Session() = default;
Session::Session(Session&& other) noexcept = default;
Session& Session::operator=(Session&& other) noexcept = default;

void Session::acquire(const std::string& holder) { stream_->acquire(holder); }

void Session::load_scene(const std::string& scene) {
  v1::Item item;
  if (is_text(scene)) {
    item.mutable_load_scene()->set_text(scene);
  } else {
    item.mutable_load_scene()->set_name(scene);
  }
  stream_->load_scene(std::move(item));
}

void Session::set(const std::string& path, const Value& value) { set({{path, value}}); }

void Session::set(const std::vector<std::pair<std::string, Value>>& values) {
  v1::Item item;
  for (const auto& [path, value] : values) {
    *item.mutable_set_parameter()->add_assignments() = assignment(path, value);
  }
  item.mutable_set_parameter();
  stream_->request(std::move(item));
}

Value Session::get(const std::string& path) {
  std::map<std::string, Value> found = values({path});
  const auto one = found.find(path);
  if (one != found.end()) return std::move(one->second);
  throw Error(v1::RESULT_CODE_INVALID, path, path + " is not one parameter, but several.");
}

std::map<std::string, Value> Session::values(const std::vector<std::string>& paths) {
  v1::Item item;
  item.mutable_get_parameters();
  for (const std::string& path : paths) item.mutable_get_parameters()->add_paths(path);
  std::map<std::string, Value> found;
  const v1::Result result = stream_->request(std::move(item));
  for (const v1::Assignment& each : result.parameters().values()) {
    found.emplace(each.path(), value_of(each));
  }
  return found;
}

void Session::subscribe(std::uint32_t divisor, const std::vector<v1::Section>& sections) {
  v1::Item item;
  item.mutable_subscribe()->set_divisor(divisor);
  for (const v1::Section section : sections) item.mutable_subscribe()->add_sections(section);
  stream_->subscribe(item);
}

RunResult Session::run(std::uint64_t steps, const std::vector<Pose>& poses, std::uint32_t tool_id) {
  return stream_->run(steps, poses, tool_id);
}

Unread Session::poll(std::chrono::nanoseconds wait) { return stream_->poll(wait); }
std::optional<v1::State> Session::next_state() { return stream_->next_state(); }
std::optional<v1::Item> Session::next_event() { return stream_->next_event(); }
const v1::SceneInfo& Session::scene() const { return stream_->scene(); }
std::optional<std::int64_t> Session::own_time_ns(std::uint64_t t_ns) const {
  return stream_->own_time_ns(t_ns);
}

void Session::play_gesture(const std::string& gesture, std::uint32_t repeat) {
  v1::Item item;
  v1::PlayGesture& play = *item.mutable_play_gesture();
  if (is_text(gesture)) {
    *play.mutable_gesture() = gesture_of(gesture);
  } else if (!gesture.empty()) {
    play.set_name(gesture);
  }
  if (!gesture.empty()) play.set_repeat(repeat);
  stream_->request(std::move(item));
}

void Session::engage() {
  v1::Item item;
  item.mutable_engage();
  stream_->request(std::move(item));
}

void Session::disengage() {
  v1::Item item;
  item.mutable_disengage();
  stream_->request(std::move(item));
}

void Session::stop() {
  v1::Item item;
  item.mutable_stop();
  stream_->request(std::move(item));
}

void Session::clear() {
  v1::Item item;
  item.mutable_clear();
  stream_->request(std::move(item));
}

std::string Session::record(v1::RecordMode mode, const std::string& file) {
  v1::Item item;
  item.mutable_record()->set_mode(mode);
  item.mutable_record()->set_file(file);
  return stream_->request(std::move(item)).recorded();
}

v1::Result Session::request(v1::Item item) { return stream_->request(std::move(item)); }

}  // namespace abi_0
}  // namespace hapticd::client
