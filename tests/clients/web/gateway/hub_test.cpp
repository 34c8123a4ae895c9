// The hub with viewers that are lists and a daemon that is a function: who gets what, who may do
// what. The rights are those of PROTOCOL.md, section 8, and of clients/web/gateway/README.md.
#include "clients/web/gateway/hub.h"

#include <doctest/doctest.h>
#include <google/protobuf/stubs/logging.h>

#include <deque>
#include <utility>
#include <vector>

namespace hapticd::test {
namespace {

using web::CloseReason;
using web::Hub;
using web::ViewerId;

/// A hub, and a daemon that keeps what it is asked until the test answers.
struct Stage {
  struct Asked {
    v1::Item item;
    client::ResultHandler done;
  };

  explicit Stage(web::QueueLimits limits = {}) : hub(options(limits)) {}

  web::HubOptions options(web::QueueLimits limits) {
    web::HubOptions made;
    made.version = "1.2.3";
    made.limits = limits;
    made.call = [this](const v1::Item& item, client::ResultHandler done) {
      if (!reachable) return false;
      asked.push_back({item, std::move(done)});
      return true;
    };
    made.steer = [this](const v1::PagePlayback& wanted) { steered.push_back(wanted); };
    made.recordings = [this] {
      ++listed;
      return v1::Listing();
    };
    made.daemon_now_ns = [] { return std::int64_t{1234}; };
    return made;
  }
  ViewerId join(bool control) {
    const std::size_t place = closed.size();
    closed.emplace_back();
    return hub.add({control, control},
                   {[] {}, [this, place](CloseReason why) { closed[place] = why; }});
  }
  std::vector<v1::PageEvent> events(ViewerId viewer) {
    std::vector<v1::PageEvent> all;
    while (const auto message = hub.next(viewer)) {
      REQUIRE(all.emplace_back().ParseFromString(*message));
    }
    return all;
  }
  void request(ViewerId viewer, std::uint64_t id, const v1::Item& item) {
    v1::PageRequest request;
    request.set_id(id);
    *request.mutable_call() = item;
    hub.take(viewer, request.SerializeAsString());
  }
  /// The answer to the request of `viewer` that came last; it must be the only event that waits.
  v1::Result answer(ViewerId viewer) {
    const auto all = events(viewer);
    REQUIRE(all.size() == 1);
    return all[0].result();
  }
  void daemon_says(v1::ResultCode code) {
    REQUIRE(!asked.empty());
    const Asked next = std::move(asked.front());
    asked.pop_front();
    v1::Result result;
    result.set_item_id(999);
    result.set_code(code);
    if (next.done) next.done(&result);
  }
  void grant(ViewerId viewer) {
    request(viewer, 1, acquire());
    daemon_says(v1::RESULT_CODE_OK);
    CHECK(answer(viewer).code() == v1::RESULT_CODE_OK);
  }
  static v1::Item acquire() {
    v1::Item item;
    item.mutable_acquire();
    return item;
  }
  static v1::Item engage() {
    v1::Item item;
    item.mutable_engage();
    return item;
  }

  bool reachable = true;
  std::deque<Asked> asked;
  std::vector<v1::PagePlayback> steered;
  int listed = 0;
  std::deque<std::optional<CloseReason>> closed;
  Hub hub;
};

v1::Item scene_item(const std::string& hash) {
  v1::Item item;
  item.mutable_scene_info()->set_scene_id(4);
  item.mutable_scene_info()->set_hash(hash);
  return item;
}

v1::Item lease_item(bool yours) {
  v1::Item item;
  item.mutable_lease_info()->set_fence(3);
  item.mutable_lease_info()->set_yours(yours);
  return item;
}

TEST_CASE(
    "who joins late is welcomed and gets scene, lease, recorder, a latched fault and the link") {
  Stage stage;
  v1::Item recorder;
  recorder.mutable_record_info()->set_state(v1::RECORD_STATE_IDLE);
  v1::Item fault;
  fault.mutable_fault()->set_latched(true);
  v1::Item tone;
  tone.mutable_tone();
  v1::PageLink link;
  link.set_state(v1::PAGE_LINK_STATE_LIVE);
  stage.hub.item(scene_item(std::string(32, 'h')));
  for (const auto& item : {lease_item(false), recorder, fault, tone}) stage.hub.item(item);
  stage.hub.link(link);
  const auto all = stage.events(stage.join(true));
  REQUIRE(all.size() == 6);
  CHECK(all[0].welcome().version() == "1.2.3");
  CHECK(all[0].welcome().control());
  CHECK(all[0].welcome().source() == v1::PAGE_SOURCE_LIVE);
  CHECK(all[0].welcome().scene_hash() == std::string(32, 'h'));
  CHECK(all[0].welcome().presentation_delay_s() == 0.008);
  CHECK(all[1].item().has_scene_info());
  CHECK(all[2].item().has_lease_info());
  CHECK(all[3].item().has_record_info());
  CHECK(all[4].item().fault().latched());
  CHECK(all[5].link().state() == v1::PAGE_LINK_STATE_LIVE);
  for (std::size_t i = 0; i < all.size(); ++i) CHECK(all[i].sequence() == i + 1);
}

TEST_CASE("who joins a recording that stands still sees where it stands") {
  Stage stage;
  v1::State state;
  for (const std::uint64_t tick : {41U, 42U}) {
    state.set_tick(tick);
    stage.hub.state(state);
  }
  const auto all = stage.events(stage.join(false));
  REQUIRE(all.size() == 2);
  CHECK(all[1].state().tick() == 42);
  stage.hub.session_ended();
  CHECK(stage.events(stage.join(false)).size() == 1);
}

TEST_CASE("a fault that was cleared is not told to who joins after it") {
  Stage stage;
  v1::Item fault;
  fault.mutable_fault()->set_latched(true);
  stage.hub.item(fault);
  fault.mutable_fault()->set_latched(false);
  stage.hub.item(fault);
  CHECK(stage.events(stage.join(false)).size() == 1);
}

TEST_CASE(
    "a viewer that reads nothing is closed by too many events, and the others see all of them") {
  Stage stage({.states = 2, .kept = 4});
  const ViewerId slow = stage.join(false);
  const ViewerId quick = stage.join(false);
  int seen = 0;
  for (int i = 0; i < 20; ++i) {
    v1::Item tone;
    tone.mutable_tone()->set_string_index(static_cast<std::uint32_t>(i));
    stage.hub.item(tone);
    v1::State state;
    state.set_tick(static_cast<std::uint64_t>(i));
    stage.hub.state(state);
    for (const auto& event : stage.events(quick)) {
      if (event.item().has_tone()) CHECK(event.item().tone().string_index() == seen++);
    }
  }
  CHECK(seen == 20);
  CHECK(stage.closed[0] == CloseReason::kTooSlow);
  CHECK_FALSE(stage.closed[1].has_value());
  CHECK(stage.hub.counters().closed_slow == 1);
  CHECK(stage.hub.next(slow) == std::nullopt);
}

TEST_CASE("a viewer that is slow for States alone stays, and its drops are counted") {
  Stage stage({.states = 2, .kept = 4});
  const ViewerId slow = stage.join(false);
  for (std::uint64_t tick = 1; tick <= 10; ++tick) {
    v1::State state;
    state.set_tick(tick);
    stage.hub.state(state);
  }
  CHECK_FALSE(stage.closed[0].has_value());
  CHECK(stage.hub.total_dropped() == 8);
  stage.hub.link({});
  const auto all = stage.events(slow);
  CHECK(all.back().link().dropped_states() == 8);
  stage.hub.remove(slow);
  CHECK(stage.hub.total_dropped() == 8);
}

TEST_CASE("a page without token looks: what needs control never reaches the daemon") {
  Stage stage;
  const ViewerId viewer = stage.join(false);
  stage.events(viewer);
  std::vector<v1::Item> refused(10);
  refused[0].mutable_acquire();
  refused[1].mutable_stop();
  refused[2].mutable_engage();
  refused[3].mutable_set_parameter();
  // What only reads costs the daemon, too.
  refused[4].mutable_get_parameters();
  refused[5].mutable_list_scenes();
  refused[6].mutable_list_gestures();
  refused[7].mutable_list_recordings();
  refused[8].mutable_get_counts();
  refused[9].mutable_replay();
  for (const v1::Item& item : refused) {
    stage.request(viewer, 7, item);
    const auto result = stage.answer(viewer);
    CHECK(result.code() == v1::RESULT_CODE_NOT_PERMITTED);
    CHECK(result.item_id() == 7);
  }
  CHECK(stage.asked.empty());
}

TEST_CASE("a page without token moves no recording and gets no list, and is told why") {
  Stage stage;
  const ViewerId viewer = stage.join(false);
  CHECK_FALSE(stage.events(viewer).at(0).welcome().steer());
  std::vector<v1::PageRequest> refused(4);
  refused[0].mutable_playback()->set_playing(false);
  refused[1].mutable_list_recordings();
  refused[2].mutable_show()->set_recording("session.mcap");
  refused[3].mutable_show();
  for (v1::PageRequest& request : refused) {
    request.set_id(9);
    stage.hub.take(viewer, request.SerializeAsString());
    const auto result = stage.answer(viewer);
    CHECK(result.code() == v1::RESULT_CODE_NOT_PERMITTED);
    CHECK(result.item_id() == 9);
    CHECK(result.message().find("token") != std::string::npos);
  }
  CHECK(stage.steered.empty());
  CHECK(stage.listed == 0);
  CHECK(stage.hub.counters().refused == 4);
}

TEST_CASE("where a recording is the only source a page with the token moves it, and that is all") {
  Stage stage;
  const ViewerId viewer = stage.hub.add({false, true}, {[] {}, [](CloseReason) {}});
  const auto welcome = stage.events(viewer).at(0).welcome();
  CHECK(welcome.steer());
  CHECK_FALSE(welcome.control());
  v1::PageRequest request;
  request.mutable_playback()->set_position_s(2.0);
  stage.hub.take(viewer, request.SerializeAsString());
  CHECK(stage.steered.size() == 1);
  stage.request(viewer, 1, Stage::acquire());
  CHECK(stage.answer(viewer).code() == v1::RESULT_CODE_NOT_PERMITTED);
}

TEST_CASE("a viewer that gives way is told so, and asks no more") {
  Stage stage;
  const ViewerId viewer = stage.join(true);
  stage.hub.end(viewer, CloseReason::kGaveWay);
  CHECK(stage.closed[0] == CloseReason::kGaveWay);
  stage.request(viewer, 1, Stage::acquire());
  CHECK(stage.asked.empty());
  CHECK(stage.hub.counters().gave_way == 1);
  stage.hub.end(viewer + 1, CloseReason::kGaveWay);
}

int protobuf_lines = 0;

TEST_CASE("text of a page that is not UTF-8 closes it, and writes nothing to the log") {
  auto* const before = google::protobuf::SetLogHandler(
      [](google::protobuf::LogLevel, const char*, int, const std::string&) { ++protobuf_lines; });
  Stage stage;
  const ViewerId viewer = stage.join(true);
  v1::PageRequest request;
  request.mutable_show()->set_recording("####");
  std::string bytes = request.SerializeAsString();
  bytes.replace(bytes.find("####"), 4, "\xff\xfe\xc0\x80");
  stage.hub.take(viewer, bytes);
  google::protobuf::SetLogHandler(before);
  CHECK(stage.closed[0] == CloseReason::kGarbage);
  CHECK(stage.hub.counters().closed_garbage == 1);
  CHECK(protobuf_lines == 0);
}

TEST_CASE("subscriptions, goodbyes and poses of pages are refused, with control too") {
  Stage stage;
  const ViewerId viewer = stage.join(true);
  stage.events(viewer);
  std::vector<v1::Item> refused(5);
  refused[0].mutable_subscribe();
  refused[1].mutable_bye();
  refused[2].mutable_pose_batch();
  refused[3].mutable_chunk();
  for (const v1::Item& item : refused) {  // the last one is empty
    stage.request(viewer, 7, item);
    CHECK(stage.answer(viewer).code() == v1::RESULT_CODE_UNSUPPORTED);
  }
  CHECK(stage.asked.empty());
}

TEST_CASE("the lease is one page's: others are told so, until it lets go") {
  Stage stage;
  const ViewerId one = stage.join(true);
  const ViewerId two = stage.join(true);
  stage.events(one);
  stage.events(two);
  stage.request(one, 1, Stage::acquire());
  // While it is on the way nobody else's is sent.
  stage.request(two, 1, Stage::acquire());
  CHECK(stage.answer(two).code() == v1::RESULT_CODE_BUSY);
  stage.daemon_says(v1::RESULT_CODE_OK);
  CHECK(stage.answer(one).code() == v1::RESULT_CODE_OK);
  stage.hub.item(lease_item(true));
  CHECK(stage.events(one).at(0).item().lease_info().yours());
  CHECK_FALSE(stage.events(two).at(0).item().lease_info().yours());
  stage.request(two, 2, Stage::engage());
  CHECK(stage.answer(two).code() == v1::RESULT_CODE_NOT_OWNER);
  stage.request(one, 2, Stage::engage());
  CHECK(stage.asked.size() == 1);
  stage.daemon_says(v1::RESULT_CODE_OK);
  v1::Item release;
  release.mutable_release();
  stage.request(one, 3, release);
  stage.daemon_says(v1::RESULT_CODE_OK);
  stage.grant(two);
}

TEST_CASE("a page with control takes over from another with a reason, a page without does not") {
  Stage stage;
  const ViewerId one = stage.join(true);
  const ViewerId two = stage.join(true);
  const ViewerId looker = stage.join(false);
  for (const ViewerId each : {one, two, looker}) stage.events(each);
  stage.grant(one);
  v1::Item take_over = Stage::acquire();
  take_over.mutable_acquire()->set_take_over("lunch is over");
  stage.request(looker, 1, take_over);
  CHECK(stage.answer(looker).code() == v1::RESULT_CODE_NOT_PERMITTED);
  stage.request(two, 1, take_over);
  REQUIRE(stage.asked.size() == 1);
  CHECK(stage.asked[0].item.acquire().take_over() == "lunch is over");
  stage.daemon_says(v1::RESULT_CODE_OK);
  CHECK(stage.answer(two).code() == v1::RESULT_CODE_OK);
  stage.hub.item(lease_item(true));
  CHECK(stage.events(two).at(0).item().lease_info().yours());
  CHECK_FALSE(stage.events(one).at(0).item().lease_info().yours());
  stage.request(one, 2, Stage::engage());
  CHECK(stage.answer(one).code() == v1::RESULT_CODE_NOT_OWNER);
}

TEST_CASE("any page with control may stop, whoever has the lease") {
  Stage stage;
  const ViewerId one = stage.join(true);
  const ViewerId two = stage.join(true);
  stage.events(one);
  stage.events(two);
  stage.grant(one);
  v1::Item stop;
  stop.mutable_stop();
  stage.request(two, 5, stop);
  REQUIRE(stage.asked.size() == 1);
  CHECK(stage.asked[0].item.has_stop());
}

TEST_CASE("a page that closes gives the lease back, also when its grant comes after it") {
  Stage stage;
  const ViewerId one = stage.join(true);
  stage.events(one);
  stage.grant(one);
  stage.hub.remove(one);
  REQUIRE(stage.asked.size() == 1);
  CHECK(stage.asked[0].item.has_release());
  stage.daemon_says(v1::RESULT_CODE_OK);
  const ViewerId two = stage.join(true);
  stage.request(two, 1, Stage::acquire());
  stage.hub.remove(two);
  stage.daemon_says(v1::RESULT_CODE_OK);
  REQUIRE(stage.asked.size() == 1);
  CHECK(stage.asked[0].item.has_release());
}

TEST_CASE("who lost the lease by the daemon's word, or with the session, has to take it again") {
  Stage stage;
  const ViewerId one = stage.join(true);
  stage.events(one);
  stage.grant(one);
  stage.hub.item(lease_item(false));
  stage.events(one);
  stage.request(one, 2, Stage::engage());
  CHECK(stage.answer(one).code() == v1::RESULT_CODE_NOT_OWNER);
  stage.grant(one);
  stage.hub.session_ended();
  stage.request(one, 3, Stage::engage());
  CHECK(stage.answer(one).code() == v1::RESULT_CODE_NOT_OWNER);
}

TEST_CASE("requests that find no daemon, or whose session ends, are answered") {
  Stage stage;
  const ViewerId viewer = stage.join(true);
  stage.events(viewer);
  v1::Item ping;
  ping.mutable_ping();
  stage.reachable = false;
  stage.request(viewer, 1, ping);
  CHECK(stage.answer(viewer).code() == v1::RESULT_CODE_FAILED);
  stage.reachable = true;
  stage.request(viewer, 2, ping);
  stage.asked.front().done(nullptr);
  CHECK(stage.answer(viewer).code() == v1::RESULT_CODE_FAILED);
}

TEST_CASE("64 requests of a page may be under way, one more is BUSY") {
  Stage stage;
  const ViewerId viewer = stage.join(true);
  stage.events(viewer);
  v1::Item ping;
  ping.mutable_ping();
  for (std::uint64_t id = 1; id <= 64; ++id) stage.request(viewer, id, ping);
  CHECK(stage.events(viewer).empty());
  stage.request(viewer, 65, ping);
  CHECK(stage.answer(viewer).code() == v1::RESULT_CODE_BUSY);
  stage.daemon_says(v1::RESULT_CODE_OK);
  CHECK(stage.answer(viewer).item_id() == 1);
  stage.request(viewer, 66, ping);
  CHECK(stage.events(viewer).empty());
}

TEST_CASE("a ping is answered with the daemon's clock, and steering reaches the recording") {
  Stage stage;
  const ViewerId viewer = stage.join(true);
  stage.events(viewer);
  v1::PageRequest request;
  request.mutable_ping()->set_sent_s(8.125);
  stage.hub.take(viewer, request.SerializeAsString());
  const auto pong = stage.events(viewer).at(0).pong();
  CHECK(pong.sent_s() == 8.125);
  CHECK(pong.daemon_t_ns() == 1234);
  request.mutable_playback()->set_position_s(3.0);
  stage.hub.take(viewer, request.SerializeAsString());
  REQUIRE(stage.steered.size() == 1);
  CHECK(stage.steered[0].position_s() == 3.0);
}

TEST_CASE("a viewer that sends what is no request is closed") {
  Stage stage;
  const ViewerId viewer = stage.join(true);
  stage.hub.take(viewer, "\xff\xff\xff");
  CHECK(stage.closed[0] == CloseReason::kGarbage);
}

}  // namespace
}  // namespace hapticd::test
