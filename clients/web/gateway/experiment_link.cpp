// See experiment_link.h.
#include "clients/web/gateway/experiment_link.h"

#include <google/protobuf/util/json_util.h>

#include <system_error>
#include <utility>

#include "proto/recording/default_recordings.h"
#include "proto/wire/request_result.h"

namespace hapticd::web {
namespace {

namespace json = google::protobuf::util;
using wire::result_of;

constexpr std::size_t kMaxNameBytes = 64;

/// A name that is a folder, and no option, and leads nowhere.
bool is_name(std::string_view name) {
  constexpr std::string_view kLetters =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_";
  return !name.empty() && name.size() <= kMaxNameBytes && name.front() != '-' &&
         name.find_first_not_of(kLetters) == std::string_view::npos;
}

bool is_last(const v1::ExperimentScreen& screen) {
  return screen.stage() == v1::EXPERIMENT_STAGE_DONE ||
         screen.stage() == v1::EXPERIMENT_STAGE_STOPPED;
}

}  // namespace

ExperimentLink::ExperimentLink(boost::asio::io_context& context, ExperimentOptions options,
                               ScreenHandler shown)
    : context_(context), options_(std::move(options)), shown_(std::move(shown)) {}

ExperimentLink::~ExperimentLink() = default;

v1::Result ExperimentLink::take(ViewerId viewer, bool control, const v1::PageExperiment& asked) {
  if (!control) return only_looks();
  if (asked.has_begin()) return begin(viewer, asked.begin());
  if (program_ == nullptr) return result_of(v1::RESULT_CODE_WRONG_STATE, "", "no experiment runs");
  if (asked.has_answer()) return answer(viewer, asked.answer());
  // Who may control ends what another page began, too: that page may lie in another room.
  if (asked.has_end()) stop();
  return result_of(v1::RESULT_CODE_OK);
}

v1::Result ExperimentLink::begin(ViewerId viewer, const v1::ExperimentBegin& wanted) {
  if (program_ != nullptr) {
    return result_of(v1::RESULT_CODE_BUSY, "",
                     "the experiment of " + screen_.participant() + " is running. End it first");
  }
  if (!is_name(wanted.participant())) {
    return result_of(v1::RESULT_CODE_INVALID, "experiment.begin.participant",
                     "a participant's name has letters, digits, - and _, 64 at most, such as P1");
  }
  LineHandlers handlers;
  handlers.line = [this](const std::string& line) { said(line); };
  handlers.ended = [this](int exit_code) { ended(exit_code); };
  auto program = std::make_shared<ChildProcess>(context_, std::move(handlers));
  try {
    program->start(words(wanted));
  } catch (const std::system_error& error) {
    return result_of(v1::RESULT_CODE_FAILED, "",
                     std::string("hapticd-lab does not start: ") + error.what() +
                         ". Install it beside haptic-web, or add its folder to PATH");
  }
  program_ = std::move(program);
  owner_ = viewer;
  screen_.Clear();
  screen_.set_participant(wanted.participant());
  return result_of(v1::RESULT_CODE_OK);
}

std::vector<std::string> ExperimentLink::words(const v1::ExperimentBegin& wanted) const {
  const std::string& name = wanted.participant();
  std::vector<std::string> all{
      options_.program.empty() ? program_beside("hapticd-lab") : options_.program.string(),
      "experiment",
      "--page",
      "--address=" + options_.address,
      "--participant=" + name,
      "--seed=" + std::to_string(wanted.seed()),
      "--output=" + (options_.folder / name).string()};
  if (wanted.repetitions() > 0) {
    all.push_back("--repetitions=" + std::to_string(wanted.repetitions()));
  }
  if (!options_.key.empty()) all.push_back("--key=" + options_.key.string());
  return all;
}

v1::Result ExperimentLink::answer(ViewerId viewer, const v1::ExperimentAnswer& answer) {
  if (viewer != owner_) {
    return result_of(v1::RESULT_CODE_NOT_OWNER, "", "another page began this experiment");
  }
  std::string line;
  if (!json::MessageToJsonString(answer, &line).ok()) {
    return result_of(v1::RESULT_CODE_INVALID, "", "this is not an answer");
  }
  program_->say(line);
  return result_of(v1::RESULT_CODE_OK);
}

void ExperimentLink::gone(ViewerId viewer) {
  if (viewer == owner_) stop();
}

void ExperimentLink::stop() {
  if (program_ != nullptr) program_->finish();
}

void ExperimentLink::said(const std::string& line) {
  json::JsonParseOptions options;
  options.ignore_unknown_fields = true;
  v1::ExperimentScreen screen;
  if (!json::JsonStringToMessage(line, &screen, options).ok()) return;
  screen_ = std::move(screen);
  shown_(screen_, owner_);
}

void ExperimentLink::ended(int exit_code) {
  program_.reset();
  if (!is_last(screen_)) {
    screen_.set_number(screen_.number() + 1);
    screen_.set_stage(v1::EXPERIMENT_STAGE_STOPPED);
    screen_.set_text("hapticd-lab ended with exit code " + std::to_string(exit_code) +
                     "; its messages are in the output of haptic-web. All answers are kept");
    shown_(screen_, owner_);
  }
  owner_ = 0;
}

std::filesystem::path default_experiments() {
  return default_recordings().parent_path() / "experiments";
}

}  // namespace hapticd::web
