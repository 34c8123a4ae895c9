// See stop_call.h.
#include "proto/stop/stop_call.h"

#include <algorithm>

namespace hapticd::stop {

StopCall::StopCall(Kind kind, const StopTarget& target, std::uint64_t client)
    : target_(target), kind_(kind) {
  request_.kind = kind;
  request_.session_port = target.session_port;
  request_.client = client;
}

// Once the daemon has the Stop, only whether its loop has latched it is of interest: another STOP
// might be one too many after somebody's Clear.
Datagram StopCall::next() {
  ++request_.number;
  request_.kind = asked_ ? Kind::kQuery : kind_;
  Datagram datagram = encode(request_);
  if (target_.key) seal(datagram, target_.key->get());
  return datagram;
}

bool StopCall::receive(std::span<const std::uint8_t> bytes) {
  const std::optional<Answer> answer = parse_answer(bytes);
  if (!answer || answer->client != request_.client || answer->number == 0 ||
      answer->number > request_.number) {
    return false;
  }
  Datagram datagram;
  std::copy(bytes.begin(), bytes.end(), datagram.begin());
  if (target_.key ? !opens(datagram, target_.key->get()) : is_sealed(datagram)) return false;
  if (answer_ && answer->number < answer_->number) return true;
  answer_ = answer;
  if (target_.key) request_.challenge = answer->challenge;
  const bool stops = kind_ == Kind::kStop;
  switch (answer->code) {
    case Code::kDone:
      asked_ = asked_ || (stops && answer->kind == Kind::kStop);
      // One that is latched no more was cleared since.
      if (!stops || (asked_ && answer->latch != Latch::kAsked)) state_ = State::kDone;
      break;
    case Code::kChallenge:
      break;
    case Code::kOtherDaemon:
      state_ = State::kOtherDaemon;
      break;
    default:
      state_ = State::kRefused;
      break;
  }
  return true;
}

}  // namespace hapticd::stop
