// A gateway of a running daemon that shows a recording meanwhile: a page with control asks for it
// by name, all pages see it, and the daemon again when that is asked for. What a page must get is
// in clients/web/gateway/README.md.
#include <doctest/doctest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "clients/web/gateway/recording_folder.h"
#include "tests/clients/web/gateway/browser.h"
#include "tests/clients/web/gateway/fake_daemon.h"
#include "tests/clients/web/gateway/running_gateway.h"
#include "tests/clients/web/gateway/sample_recording.h"

namespace hapticd::test {
namespace {

namespace fs = std::filesystem;

/// The recorded scene; that of the FakeDaemon is 1.
constexpr std::uint32_t kRecordedScene = 77;
/// Ticks of the recording, numbered from here: the daemon's begin at 0 and do not get as far.
constexpr std::uint64_t kFirstTick = 5'000'000;
constexpr std::uint64_t kTicks = 4'000;

/// A folder with a recording of 4 s in it, and a file beside the folder.
struct Folder {
  Folder() {
    std::string name = (fs::temp_directory_path() / "hapticd_XXXXXX").string();
    REQUIRE(::mkdtemp(name.data()) != nullptr);
    root = name;
    path = root / "recordings";
    fs::create_directory(path);
    recording().save((path / "session.mcap").string());
    recording().save((root / "outside.mcap").string());
  }
  ~Folder() { fs::remove_all(root); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  static SampleRecording recording() {
    SampleRecording made;
    v1::RecordHeader header;
    header.set_format_version(2);
    header.set_period_ns(1'000'000);
    made.message(1, 1, header.SerializeAsString());
    v1::SceneRecord scene;
    scene.set_scene_id(kRecordedScene);
    scene.set_hash(std::string(32, 'r'));
    made.message(2, 1, scene.SerializeAsString());
    for (std::uint64_t i = 0; i < kTicks; ++i) {
      v1::TickRecord tick;
      tick.set_tick(kFirstTick + i);
      tick.set_scene_id(kRecordedScene);
      made.message(4, 1 + 1'000'000 * i, tick.SerializeAsString());
      if (i % 1000 == 999) made.close_chunk();
    }
    return made;
  }

  fs::path root;
  fs::path path;
};

web::WebOptions options_with(const Folder& folder, const FakeDaemon& daemon) {
  web::WebOptions options = options_for(daemon.port());
  options.recordings = folder.path;
  return options;
}

v1::PageRequest show(const std::string& name) {
  v1::PageRequest request;
  request.mutable_show()->set_recording(name);
  return request;
}

v1::PageRequest list() {
  v1::PageRequest request;
  request.mutable_list_recordings();
  return request;
}

v1::Item acquire() {
  v1::Item item;
  item.mutable_acquire()->set_holder("page");
  return item;
}

bool is_live(const v1::PageEvent& event) {
  return event.link().state() == v1::PAGE_LINK_STATE_LIVE;
}

bool shows_recording(const v1::PageEvent& event) {
  return event.shown().source() == v1::PAGE_SOURCE_RECORDING;
}

bool shows_daemon(const v1::PageEvent& event) {
  return event.shown().source() == v1::PAGE_SOURCE_LIVE;
}

/// The next `count` States of `page` are of the recording, or of the daemon.
void check_states(Browser& page, bool recorded, int count = 20) {
  for (int i = 0; i < count; ++i) {
    const auto event = page.wait_for([](const auto& each) { return each.has_state(); });
    REQUIRE((event.state().tick() >= kFirstTick) == recorded);
  }
}

TEST_CASE("a recording that a page with control asks for is shown to all, and then the daemon") {
  const Folder folder;
  FakeDaemon daemon;
  RunningGateway gateway(options_with(folder, daemon));
  Browser holder(gateway.port(), gateway.control());
  Browser looker(gateway.port());
  holder.wait_for(is_live);
  holder.send(show("session.mcap"));
  for (Browser* page : {&holder, &looker}) {
    const v1::PageShown shown = page->wait_for(shows_recording).shown();
    CHECK(shown.recording() == "session.mcap");
    CHECK_FALSE(shown.cut_off());
    const auto scene =
        page->wait_for([](const auto& event) { return event.item().has_scene_info(); });
    CHECK(scene.item().scene_info().scene_id() == kRecordedScene);
    check_states(*page, true);
    const auto place = page->wait_for([](const auto& event) { return event.has_playback(); });
    CHECK(place.playback().duration_s() == doctest::Approx(3.999));
    // The daemon's session goes on, and says so.
    page->wait_for(is_live);
  }
  holder.send(show(""));
  for (Browser* page : {&holder, &looker}) {
    page->wait_for(shows_daemon);
    const auto scene =
        page->wait_for([](const auto& event) { return event.item().has_scene_info(); });
    CHECK(scene.item().scene_info().hash() == std::string(32, 's'));
    check_states(*page, false);
  }
}

TEST_CASE("a page with control moves the recording that is shown, and time goes by in it") {
  const Folder folder;
  FakeDaemon daemon;
  RunningGateway gateway(options_with(folder, daemon));
  Browser holder(gateway.port(), gateway.control());
  Browser other(gateway.port(), gateway.control());
  Browser looker(gateway.port());
  CHECK(holder.ask(show("session.mcap")).code() == v1::RESULT_CODE_OK);
  looker.wait_for(shows_recording);
  v1::PageRequest seek;
  seek.mutable_playback()->set_position_s(1.0);
  seek.mutable_playback()->set_rate(1.0);
  CHECK(looker.ask(seek).code() == v1::RESULT_CODE_NOT_PERMITTED);
  seek.mutable_playback()->set_position_s(3.0);
  other.send(seek);
  const auto there = holder.wait_for(
      [](const auto& event) { return event.has_playback() && !event.playback().playing(); });
  CHECK(there.playback().position_s() == doctest::Approx(3.0));
  // Who comes now sees the tick where it stands.
  Browser late(gateway.port());
  const auto welcome = late.next().welcome();
  CHECK(welcome.source() == v1::PAGE_SOURCE_RECORDING);
  CHECK(welcome.scene_hash() == std::string(32, 'r'));
  late.wait_for(shows_recording);
  const auto state = late.wait_for([](const auto& event) { return event.has_state(); }).state();
  CHECK(state.tick() == kFirstTick + 3000);
}

TEST_CASE(
    "who only looks, and who does not hold the lease that another page holds, shows nothing") {
  const Folder folder;
  FakeDaemon daemon;
  RunningGateway gateway(options_with(folder, daemon));
  Browser holder(gateway.port(), gateway.control());
  Browser other(gateway.port(), gateway.control());
  Browser looker(gateway.port());
  holder.wait_for(is_live);
  CHECK(looker.ask(show("session.mcap")).code() == v1::RESULT_CODE_NOT_PERMITTED);
  CHECK(holder.call(acquire()).code() == v1::RESULT_CODE_OK);
  CHECK(other.ask(show("session.mcap")).code() == v1::RESULT_CODE_NOT_OWNER);
  CHECK(holder.ask(show("session.mcap")).code() == v1::RESULT_CODE_OK);
  CHECK(other.ask(show("")).code() == v1::RESULT_CODE_NOT_OWNER);
  CHECK(looker.ask(show("")).code() == v1::RESULT_CODE_NOT_PERMITTED);
  check_states(looker, true);
  // The lease holds meanwhile, and what is asked of the daemon reaches it.
  v1::Item engage;
  engage.mutable_engage();
  CHECK(holder.call(engage).code() == v1::RESULT_CODE_OK);
  CHECK(daemon.requests().back().has_engage());
}

TEST_CASE("a gateway of a recording alone has a token, which moves the recording and no more") {
  const Folder folder;
  web::WebOptions options;
  options.recording = folder.path / "session.mcap";
  RunningGateway gateway(options);
  Browser holder(gateway.port(), gateway.control());
  Browser looker(gateway.port());
  const auto welcome = holder.next().welcome();
  CHECK(welcome.steer());
  CHECK_FALSE(welcome.control());
  CHECK_FALSE(looker.next().welcome().steer());
  v1::PageRequest pause;
  pause.mutable_playback()->set_position_s(1.0);
  pause.mutable_playback()->set_rate(1.0);
  CHECK(looker.ask(pause).code() == v1::RESULT_CODE_NOT_PERMITTED);
  holder.send(pause);
  const auto there = looker.wait_for(
      [](const auto& event) { return event.has_playback() && !event.playback().playing(); });
  CHECK(there.playback().position_s() == doctest::Approx(1.0));
  CHECK(holder.call(acquire()).code() == v1::RESULT_CODE_NOT_PERMITTED);
  CHECK(holder.ask(show("")).code() == v1::RESULT_CODE_NOT_PERMITTED);
}

TEST_CASE("a recording is shown where no daemon is") {
  const Folder folder;
  std::uint16_t port = 0;
  {
    const FakeDaemon gone;
    port = gone.port();
  }
  web::WebOptions options = options_for(port);
  options.recordings = folder.path;
  RunningGateway gateway(options);
  Browser page(gateway.port(), gateway.control());
  CHECK(page.ask(show("session.mcap")).code() == v1::RESULT_CODE_OK);
  check_states(page, true);
}

TEST_CASE("what cannot be shown is named with a remedy, and what is shown goes on") {
  const Folder folder;
  std::ofstream(folder.path / "text.mcap") << "this is no recording at all";
  FakeDaemon daemon;
  RunningGateway gateway(options_with(folder, daemon));
  Browser page(gateway.port(), gateway.control());
  page.wait_for(is_live);
  const v1::Result missing = page.ask(show("gone.mcap"));
  CHECK(missing.code() == v1::RESULT_CODE_NOT_FOUND);
  CHECK(missing.message().find("gone.mcap: ") == 0);
  CHECK(missing.message().find("--recordings") != std::string::npos);
  const v1::Result damaged = page.ask(show("text.mcap"));
  CHECK(damaged.code() == v1::RESULT_CODE_FAILED);
  CHECK(damaged.message().find("text.mcap: not a recording") != std::string::npos);
  CHECK(damaged.message().find(". Name a file") != std::string::npos);
  check_states(page, false);
  CHECK(page.ask(show("session.mcap")).code() == v1::RESULT_CODE_OK);
  CHECK(page.ask(show("text.mcap")).code() == v1::RESULT_CODE_FAILED);
  check_states(page, true);
}

TEST_CASE("a recording that was cut off plays as far as it goes, and says that it is less") {
  const Folder folder;
  fs::resize_file(folder.path / "session.mcap", fs::file_size(folder.path / "session.mcap") - 60);
  FakeDaemon daemon;
  RunningGateway gateway(options_with(folder, daemon));
  Browser page(gateway.port(), gateway.control());
  page.send(show("session.mcap"));
  CHECK(page.wait_for(shows_recording).shown().cut_off());
  // The last of four chunks, of 1 s each, is gone.
  const auto place = page.wait_for([](const auto& event) { return event.has_playback(); });
  CHECK(place.playback().duration_s() == doctest::Approx(2.999));
  check_states(page, true);
}

TEST_CASE("recordings are listed oldest first, and no name leads out of their folder") {
  const Folder folder;
  fs::create_symlink(folder.root / "outside.mcap", folder.path / "link.mcap");
  fs::create_directory(folder.path / "folder.mcap");
  Folder::recording().save((folder.path / ".hidden.mcap").string());
  Folder::recording().save((folder.path / "older.mcap").string());
  std::ofstream(folder.path / "notes.txt") << "no recording";
  // A name that is no text: nobody could be told.
  Folder::recording().save((folder.path / "n\xffne.mcap").string());
  const auto now = fs::file_time_type::clock::now();
  fs::last_write_time(folder.path / "session.mcap", now);
  fs::last_write_time(folder.path / "older.mcap", now - std::chrono::hours(1));
  FakeDaemon daemon;
  RunningGateway gateway(options_with(folder, daemon));
  CHECK(Browser(gateway.port()).ask(list()).code() == v1::RESULT_CODE_NOT_PERMITTED);
  Browser page(gateway.port(), gateway.control());
  const v1::Listing listed = page.ask(list()).listing();
  REQUIRE(listed.names_size() == 2);
  CHECK(listed.names(0) == "older.mcap");
  CHECK(listed.names(1) == "session.mcap");
  const web::RecordingFolder shelf(folder.path);
  fs::path file;
  const std::string outside = (folder.root / "outside.mcap").string();
  const std::string cut = std::string("session.mcap\0.mcap", 18);
  for (const std::string& name :
       {std::string("../outside.mcap"), outside, std::string("./session.mcap"), cut,
        std::string("..mcap"), std::string(".mcap"), std::string("notes.txt"),
        std::string(".hidden.mcap"), std::string(252, 'x') + ".mcap"}) {
    CAPTURE(name);
    CHECK(shelf.find(name, file).code() == v1::RESULT_CODE_INVALID);
  }
  for (const char* name : {"link.mcap", "folder.mcap"}) {
    CAPTURE(name);
    CHECK(shelf.find(name, file).code() == v1::RESULT_CODE_NOT_FOUND);
  }
  CHECK(file.empty());
  CHECK(shelf.find("session.mcap", file).code() == v1::RESULT_CODE_OK);
  CHECK(file == folder.path / "session.mcap");
  CHECK(web::RecordingFolder(folder.root / "nowhere").list().names_size() == 0);
}

}  // namespace
}  // namespace hapticd::test
