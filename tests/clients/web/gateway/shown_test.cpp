// What the hub tells its viewers while a recording is shown, of the recording and of the daemon:
// the rules of clients/web/gateway/README.md.
#include <doctest/doctest.h>

#include <string>
#include <vector>

#include "clients/web/gateway/hub.h"

namespace hapticd::test {
namespace {

using web::Hub;
using web::ViewerId;

/// A hub and one viewer that only looks.
struct Scene {
  Scene() { (void)heard(); }

  std::vector<v1::PageEvent> heard() {
    std::vector<v1::PageEvent> all;
    while (const auto message = hub.next(viewer)) {
      REQUIRE(all.emplace_back().ParseFromString(*message));
    }
    return all;
  }
  void show_recording() {
    v1::PageShown shown;
    shown.set_source(v1::PAGE_SOURCE_RECORDING);
    shown.set_recording("a.mcap");
    hub.show(shown);
  }

  Hub hub{web::HubOptions{}};
  ViewerId viewer = hub.add({}, {[] {}, [](web::CloseReason) {}});
};

v1::Item scene_item(char letter) {
  v1::Item item;
  item.mutable_scene_info()->set_hash(std::string(32, letter));
  return item;
}

v1::Item fault_item(bool latched, const std::string& message = "") {
  v1::Item item;
  item.mutable_fault()->set_latched(latched);
  item.mutable_fault()->set_message(message);
  return item;
}

v1::State state_of(std::uint64_t tick) {
  v1::State state;
  state.set_tick(tick);
  return state;
}

TEST_CASE("of the daemon only lease, recorder and link pass while a recording is shown") {
  Scene scene;
  scene.show_recording();
  (void)scene.heard();
  v1::Item tone;
  tone.mutable_tone();
  v1::Item lease;
  lease.mutable_lease_info()->set_fence(3);
  v1::Item recorder;
  recorder.mutable_record_info()->set_state(v1::RECORD_STATE_RECORDING);
  scene.hub.state(state_of(9));
  for (const auto& item : {scene_item('d'), tone, lease, recorder}) scene.hub.item(item);
  scene.hub.link({});
  const auto all = scene.heard();
  REQUIRE(all.size() == 3);
  CHECK(all[0].item().has_lease_info());
  CHECK(all[1].item().has_record_info());
  CHECK(all[2].has_link());
}

TEST_CASE("of a recording nothing passes when it is not shown, and never its lease and recorder") {
  Scene scene;
  v1::Item lease;
  lease.mutable_lease_info()->set_yours(true);
  v1::Item recorder;
  recorder.mutable_record_info();
  scene.hub.recorded_state(state_of(9));
  scene.hub.recorded_item(scene_item('r'));
  CHECK(scene.heard().empty());
  scene.show_recording();
  (void)scene.heard();
  scene.hub.recorded_item(lease);
  scene.hub.recorded_item(recorder);
  CHECK(scene.heard().empty());
  scene.hub.recorded_item(scene_item('r'));
  scene.hub.recorded_state(state_of(9));
  CHECK(scene.heard().size() == 2);
}

TEST_CASE("back at the daemon its scene, fault and newest State are told anew, and no playback") {
  Scene scene;
  scene.hub.item(scene_item('d'));
  scene.show_recording();
  scene.hub.recorded_item(scene_item('r'));
  scene.hub.recorded_item(fault_item(true, "of then"));
  scene.hub.recorded_state(state_of(1));
  v1::PagePlayback playback;
  playback.set_position_s(0.5);
  scene.hub.playback(playback);
  scene.hub.item(scene_item('e'));
  scene.hub.item(fault_item(true, "of now"));
  scene.hub.state(state_of(12));
  (void)scene.heard();
  scene.hub.show(web::daemon_shown());
  const auto all = scene.heard();
  REQUIRE(all.size() == 4);
  CHECK(all[0].shown().source() == v1::PAGE_SOURCE_LIVE);
  CHECK(all[0].shown().recording().empty());
  CHECK(all[1].item().scene_info().hash() == std::string(32, 'e'));
  CHECK(all[2].item().fault().message() == "of now");
  CHECK(all[3].state().tick() == 12);
  // Who joins now is told nothing of the recording.
  const ViewerId late = scene.hub.add({}, {[] {}, [](web::CloseReason) {}});
  while (const auto message = scene.hub.next(late)) {
    v1::PageEvent event;
    REQUIRE(event.ParseFromString(*message));
    CHECK_FALSE(event.has_playback());
    CHECK_FALSE(event.has_shown());
  }
}

TEST_CASE("a fault of the daemon is told while a recording is shown, and its end, each once") {
  Scene scene;
  scene.show_recording();
  (void)scene.heard();
  scene.hub.item(fault_item(true, "device lost"));
  scene.hub.item(fault_item(true, "device lost"));
  scene.hub.item(fault_item(false));
  const auto all = scene.heard();
  REQUIRE(all.size() == 2);
  CHECK(all[0].shown().daemon_fault() == "device lost");
  CHECK(all[0].shown().recording() == "a.mcap");
  CHECK(all[1].shown().daemon_fault().empty());
  scene.hub.item(fault_item(true));
  CHECK_FALSE(scene.heard().at(0).shown().daemon_fault().empty());
  scene.hub.session_ended();
  CHECK(scene.heard().at(0).shown().daemon_fault().empty());
}

TEST_CASE("a fault that the daemon has latched before is told with the recording") {
  Scene scene;
  scene.hub.item(fault_item(true, "overrun"));
  (void)scene.heard();
  scene.show_recording();
  CHECK(scene.heard().at(0).shown().daemon_fault() == "overrun");
}

}  // namespace
}  // namespace hapticd::test
