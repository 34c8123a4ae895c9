// See page_message_target.h.
#include "tests/fuzz/page_message_target.h"

#include <google/protobuf/stubs/logging.h>

#include <array>
#include <deque>
#include <stdexcept>
#include <string>
#include <utility>

#include "clients/web/gateway/hub.h"
#include "proto/wire/request_rule.h"

namespace hapticd::test {
namespace {

void require(bool condition, const char* what) {
  if (!condition) throw std::logic_error(what);
}

/// What messages did.
struct Effects {
  int asked = 0;        ///< of the daemon
  int steered = 0;      ///< recordings
  int shown = 0;        ///< recordings
  int listed = 0;       ///< recordings
  int experiments = 0;  ///< by a page that may control

  [[nodiscard]] int all() const { return asked + steered + shown + listed + experiments; }
};

/// A page as the hub reaches it.
struct Page {
  web::ViewerRights rights;
  web::ViewerId id = 0;
  bool closed = false;
  std::uint64_t sequence = 0;
};

class Room {
 public:
  Room() : hub_(options()) {
    pages_[1].rights.steer = true;
    pages_[2].rights = {true, true};
    for (Page& page : pages_) {
      page.id = hub_.add(page.rights, {[] {}, [&page](web::CloseReason) { page.closed = true; }});
      require(events(page) == 1, "a page was not welcomed once");
    }
  }

  void say(unsigned kind, std::string_view message) {
    Page& page = pages_[kind % pages_.size()];
    reachable_ = (kind & 4U) == 0;
    const Effects before = effects_;
    const bool open = !page.closed;
    v1::PageRequest read;
    const google::protobuf::LogSilencer silence;
    const bool good = read.ParseFromArray(message.data(), static_cast<int>(message.size()));
    hub_.take(page.id, message);
    const int moved = effects_.all() - before.all();
    const int told = page.closed ? 0 : events(page);
    require(page.closed == (!open || !good), "a page was closed for a good message, or was not");
    if (page.closed) require(moved == 0, "a closed page moved something");
    if (!page.rights.control) {
      require(moved == effects_.steered - before.steered, "a page without control did something");
    }
    if (!page.rights.steer) require(moved == 0, "a page that only looks did something");
    const bool listed = effects_.listed != before.listed;
    require(moved + told <= 1 || (listed && told == 1) || answered_, "a message did two things");
    answered_ = false;
    daemon(kind);
    for (Page& each : pages_) {
      if (!each.closed) events(each);
    }
  }
  /// All pages go; whatever the daemon still answers then reaches nobody.
  void end() {
    for (Page& page : pages_) hub_.remove(page.id);
    while (!waiting_.empty()) answer(v1::RESULT_CODE_OK);
    require(hub_.viewers() == 0, "a page stayed");
  }
  [[nodiscard]] int effects() const { return effects_.all(); }

 private:
  web::HubOptions options() {
    web::HubOptions made;
    made.call = [this](const v1::Item& item, client::ResultHandler done) {
      require(wire::rule_of(item) != nullptr && !item.has_subscribe() && !item.has_pose_batch() &&
                  !item.has_bye(),
              "the daemon was asked what no page may ask");
      if (!reachable_) return false;
      ++effects_.asked;
      waiting_.push_back(std::move(done));
      return true;
    };
    made.steer = [this](const v1::PagePlayback&) { ++effects_.steered; };
    made.show = [this](const std::string&, const web::Answer& done) {
      ++effects_.shown;
      answered_ = true;
      done({});
    };
    made.recordings = [this] {
      ++effects_.listed;
      return v1::Listing();
    };
    made.experiment = [this](web::ViewerId id, bool control, const v1::PageExperiment&) {
      require(control == pages_.at(id - 1).rights.control, "another page's rights");
      effects_.experiments += control ? 1 : 0;
      answered_ = true;
      return v1::Result();
    };
    return made;
  }
  /// Takes what waits for it; their number.
  int events(Page& page) {
    int count = 0;
    while (const auto message = hub_.next(page.id)) {
      v1::PageEvent event;
      require(event.ParseFromString(*message), "an event is no PageEvent");
      require(event.sequence() == ++page.sequence, "an event was lost");
      ++count;
    }
    return count;
  }
  void daemon(unsigned kind) {
    if ((kind & 8U) != 0 && !waiting_.empty()) answer(v1::RESULT_CODE_OK);
    if ((kind & 16U) != 0 && !waiting_.empty()) answer(v1::RESULT_CODE_INVALID);
    if ((kind & 32U) == 0) return;
    while (!waiting_.empty()) answer({});
    hub_.session_ended();
  }
  /// Of the session's end: none.
  void answer(v1::ResultCode code) {
    const client::ResultHandler done = std::move(waiting_.front());
    waiting_.pop_front();
    v1::Result result;
    result.set_code(code);
    if (done) done(code == v1::RESULT_CODE_UNSPECIFIED ? nullptr : &result);
  }

  bool reachable_ = true;
  bool answered_ = false;  ///< what was asked for was done and answered at once
  Effects effects_;
  std::deque<client::ResultHandler> waiting_;
  std::array<Page, 3> pages_;
  web::Hub hub_;
};

}  // namespace

bool check_page_messages(std::span<const std::uint8_t> bytes) {
  Room room;
  while (bytes.size() >= 3) {
    const unsigned kind = bytes[0];
    const std::size_t wanted = bytes[1] + 256U * bytes[2];
    bytes = bytes.subspan(3);
    const auto message = bytes.first(std::min(wanted, bytes.size()));
    bytes = bytes.subspan(message.size());
    room.say(kind, {reinterpret_cast<const char*>(message.data()), message.size()});
  }
  const bool taken = room.effects() > 0;
  room.end();
  return taken;
}

}  // namespace hapticd::test
