// See damping_desk.h.
#include "server/daemon/damping_desk.h"

#include <spdlog/spdlog.h>

#include <string>
#include <utility>

#include "proto/wire/request_result.h"
#include "server/encoding/encode_event.h"

namespace hapticd {
namespace {

using wire::result_of;

}  // namespace

v1::Result to_result(const CheckAnswer& answer) {
  switch (answer.verdict) {
    case CheckVerdict::kRight:
      return result_of(v1::RESULT_CODE_OK, "", answer.words);
    case CheckVerdict::kFeltWrong:
      return result_of(v1::RESULT_CODE_INVALID, "calibrate.axis", answer.words);
    case CheckVerdict::kNoPush:
      return result_of(v1::RESULT_CODE_WRONG_STATE, "calibrate.step", answer.words);
    case CheckVerdict::kNotKept:
    case CheckVerdict::kNotMeasured:
      return result_of(v1::RESULT_CODE_FAILED, "calibrate", answer.words);
  }
  return {};
}

Answer DampingDesk::begin(const RequestId& id, const MeasureCommand& what, DeviceCheck& check) {
  const std::uint64_t number = loop_.next_number();
  if (!loop_.post(what)) {
    return result_of(v1::RESULT_CODE_BUSY, "", "Too many commands at once.");
  }
  asked_ = Asked{id, number, what, &check, std::nullopt};
  return std::nullopt;
}

void DampingDesk::take(const LoopEvent& event) {
  if (!asked_) return;
  const auto* const done = std::get_if<CommandDone>(&event.what);
  const auto* const refused = std::get_if<CommandRefused>(&event.what);
  if (done != nullptr && done->number == asked_->number) {
    asked_->run.emplace(asked_->what.tool, asked_->what.axis, event.tick);
  } else if (refused != nullptr && refused->number == asked_->number) {
    answer(result_of(v1::RESULT_CODE_WRONG_STATE, "", std::string(explain(refused->cause))));
  }
}

void DampingDesk::take(const Tick& tick) {
  if (!asked_ || !asked_->run) return;
  const std::optional<DampingFit> fit = asked_->run->take(tick);
  if (!fit) return;
  const CheckAnswer found = asked_->check->note_damping(asked_->what.axis, *fit);
  spdlog::info("tool {}: {}", tick.tools[asked_->what.tool].tool_id, found.words);
  answer(to_result(found));
}

void DampingDesk::answer(const v1::Result& result) {
  const RequestId id = asked_->request;
  asked_.reset();
  clients_.answer_with(id, [&] { return result; });
}

}  // namespace hapticd
