// See hub.h.
#include "clients/web/gateway/hub.h"

#include <google/protobuf/stubs/logging.h>

#include <utility>

#include "proto/wire/request_result.h"

namespace hapticd::web {
namespace {

using wire::result_of;

SharedBody link_body(const v1::PageLink& link, std::uint64_t dropped_states) {
  v1::PageEvent event;
  *event.mutable_link() = link;
  event.mutable_link()->set_dropped_states(dropped_states);
  return body_of(std::move(event));
}

SharedBody playback_body(const v1::PagePlayback& playback) {
  v1::PageEvent event;
  *event.mutable_playback() = playback;
  return body_of(std::move(event));
}

SharedBody shown_body(const v1::PageShown& shown) {
  v1::PageEvent event;
  *event.mutable_shown() = shown;
  return body_of(std::move(event));
}

bool parse(std::string_view message, v1::PageRequest& request) {
  // protobuf logs a line about text that is not UTF-8; junk must not fill the log.
  const google::protobuf::LogSilencer silence;
  return request.ParseFromArray(message.data(), static_cast<int>(message.size()));
}

std::string fault_text(const std::optional<v1::Item>& fault) {
  if (!fault.has_value()) return "";
  const std::string& said = fault->fault().message();
  return said.empty() ? "the daemon has latched a fault" : said;
}

}  // namespace

v1::PageShown daemon_shown() {
  v1::PageShown shown;
  shown.set_source(v1::PAGE_SOURCE_LIVE);
  return shown;
}

ViewerId Hub::add(ViewerRights rights, ViewerPort port) {
  const ViewerId id = ++last_id_;
  Viewer& viewer = viewers_[id];
  viewer.rights = rights;
  viewer.port = std::move(port);
  viewer.queue = ViewerQueue(options_.limits);
  ++counters_.viewers_ever;
  welcome(id, viewer);
  return id;
}

void Hub::welcome(ViewerId id, Viewer& viewer) {
  v1::PageEvent event;
  v1::PageWelcome& welcome = *event.mutable_welcome();
  welcome.set_version(options_.version);
  welcome.set_control(viewer.rights.control);
  welcome.set_steer(viewer.rights.steer);
  welcome.set_source(shown_.source());
  const Newest& of = newest();
  if (of.scene.has_value()) welcome.set_scene_hash(of.scene->scene_info().hash());
  welcome.set_presentation_delay_s(options_.presentation_delay_s);
  put(viewer, body_of(std::move(event)));
  if (shows_recording()) put(viewer, shown_body(shown_));
  const auto items = {std::cref(of.scene), std::cref(lease_), std::cref(recorder_),
                      std::cref(of.fault)};
  for (const std::optional<v1::Item>& item : items) {
    if (item.has_value()) put_item(id, viewer, *item);
  }
  if (link_.has_value()) put(viewer, link_body(*link_, 0));
  if (playback_.has_value()) put(viewer, playback_body(*playback_));
  if (experiment_.has_value()) put_experiment(id, viewer);
  if (of.state != nullptr) put_state(viewer);
}

void Hub::remove(ViewerId viewer) {
  const auto found = viewers_.find(viewer);
  if (found == viewers_.end()) return;
  counters_.dropped_states += found->second.queue.dropped_states();
  viewers_.erase(found);
  if (desk_.holder() == viewer) give_back_lease();
  if (options_.gone) options_.gone(viewer);
}

void Hub::give_back_lease() {
  v1::Item release;
  release.mutable_release();
  desk_.lost();
  if (options_.call) options_.call(release, {});
}

void Hub::put(Viewer& viewer, SharedBody body) {
  if (viewer.closing) return;
  if (!viewer.queue.add(std::move(body))) {
    close(viewer, CloseReason::kTooSlow);
  } else if (viewer.port.wake) {
    viewer.port.wake();
  }
}

void Hub::put_all(const SharedBody& body) {
  for (auto& [id, viewer] : viewers_) put(viewer, body);
}

void Hub::put_state(Viewer& viewer) {
  if (viewer.closing) return;
  viewer.queue.add_state(newest().state);
  if (viewer.port.wake) viewer.port.wake();
}

void Hub::put_item(ViewerId id, Viewer& viewer, const v1::Item& item) {
  if (!item.has_lease_info()) {
    put(viewer, item_body(item));
    return;
  }
  v1::Item own = item;
  *own.mutable_lease_info() = desk_.seen_by(id, item.lease_info());
  put(viewer, item_body(own));
}

void Hub::put_experiment(ViewerId id, Viewer& viewer) {
  v1::PageEvent event;
  *event.mutable_experiment() = *experiment_;
  event.mutable_experiment()->set_yours(id == experimenter_);
  put(viewer, body_of(std::move(event)));
}

void Hub::experiment(const v1::ExperimentScreen& screen, ViewerId owner) {
  experiment_ = screen;
  experimenter_ = owner;
  for (auto& [id, viewer] : viewers_) put_experiment(id, viewer);
}

void Hub::close(Viewer& viewer, CloseReason reason) {
  if (viewer.closing) return;
  viewer.closing = true;
  if (reason == CloseReason::kTooSlow) ++counters_.closed_slow;
  if (reason == CloseReason::kGarbage) ++counters_.closed_garbage;
  if (reason == CloseReason::kUnfinished) ++counters_.closed_unfinished;
  if (reason == CloseReason::kGaveWay) ++counters_.gave_way;
  if (viewer.port.close) viewer.port.close(reason);
}

void Hub::end(ViewerId viewer, CloseReason why) {
  const auto found = viewers_.find(viewer);
  if (found != viewers_.end()) close(found->second, why);
}

void Hub::close_all() {
  for (auto& [id, viewer] : viewers_) close(viewer, CloseReason::kEnd);
}

std::optional<std::string> Hub::next(ViewerId viewer) {
  const auto found = viewers_.find(viewer);
  if (found == viewers_.end() || found->second.closing) return std::nullopt;
  return found->second.queue.take();
}

void Hub::state(const v1::State& state) {
  ++counters_.states;
  daemon_.state = state_body(state);
  if (shows_recording()) return;
  for (auto& [id, viewer] : viewers_) put_state(viewer);
}

void Hub::recorded_state(const v1::State& state) {
  ++counters_.states;
  recording_.state = state_body(state);
  if (!shows_recording()) return;
  for (auto& [id, viewer] : viewers_) put_state(viewer);
}

void Hub::remember(const v1::Item& item, Newest& newest) {
  if (item.has_scene_info()) {
    newest.scene = item;
    newest.fault.reset();
  }
  if (item.has_fault()) {
    newest.fault = item;
    if (!item.fault().latched()) newest.fault.reset();
  }
}

void Hub::remember_daemon(const v1::Item& item) {
  remember(item, daemon_);
  if (item.has_record_info()) recorder_ = item;
  if (item.has_lease_info()) {
    lease_ = item;
    if (!item.lease_info().yours()) desk_.lost();
  }
}

void Hub::item(const v1::Item& item) {
  ++counters_.items;
  remember_daemon(item);
  if (item.has_lease_info()) {
    for (auto& [id, viewer] : viewers_) put_item(id, viewer, item);
    return;
  }
  if (shows_recording()) tell_fault();
  if (shows_recording() && !item.has_record_info()) return;
  if (!viewers_.empty()) put_all(item_body(item));
}

void Hub::recorded_item(const v1::Item& item) {
  ++counters_.items;
  // Lease and recorder of that time belong to nobody now.
  if (item.has_lease_info() || item.has_record_info()) return;
  remember(item, recording_);
  if (shows_recording() && !viewers_.empty()) put_all(item_body(item));
}

void Hub::tell_fault() {
  const std::string text = fault_text(daemon_.fault);
  if (text == shown_.daemon_fault()) return;
  shown_.set_daemon_fault(text);
  put_all(shown_body(shown_));
}

void Hub::show(const v1::PageShown& shown) {
  shown_ = shown;
  if (shows_recording()) {
    shown_.set_daemon_fault(fault_text(daemon_.fault));
  } else {
    playback_.reset();
  }
  recording_ = {};
  put_all(shown_body(shown_));
  for (const auto* item : {&newest().scene, &newest().fault}) {
    if (item->has_value()) put_all(item_body(**item));
  }
  if (newest().state == nullptr) return;
  for (auto& [id, viewer] : viewers_) put_state(viewer);
}

void Hub::session_ended() {
  // The scene stays: a page goes on showing it, and says that nothing comes.
  desk_.lost();
  daemon_.state.reset();
  lease_.reset();
  recorder_.reset();
  daemon_.fault.reset();
  if (shows_recording()) tell_fault();
}

void Hub::link(const v1::PageLink& link) {
  link_ = link;
  for (auto& [id, viewer] : viewers_) {
    put(viewer, link_body(link, viewer.queue.dropped_states()));
  }
}

void Hub::playback(const v1::PagePlayback& playback) {
  playback_ = playback;
  put_all(playback_body(playback));
}

void Hub::take(ViewerId id, std::string_view message) {
  const auto found = viewers_.find(id);
  if (found == viewers_.end() || found->second.closing) return;
  Viewer& viewer = found->second;
  v1::PageRequest request;
  if (!parse(message, request)) {
    close(viewer, CloseReason::kGarbage);
    return;
  }
  ++counters_.requests;
  if (request.has_call()) {
    call(id, viewer, request.id(), request.call());
  } else if (request.has_playback()) {
    steer(id, viewer, request.id(), request.playback());
  } else if (request.has_ping()) {
    v1::PageEvent event;
    event.mutable_pong()->set_sent_s(request.ping().sent_s());
    event.mutable_pong()->set_daemon_t_ns(options_.daemon_now_ns ? options_.daemon_now_ns() : 0);
    put(viewer, body_of(std::move(event)));
  } else if (request.has_show()) {
    show(id, viewer, request.id(), request.show());
  } else if (request.has_list_recordings()) {
    list(id, viewer, request.id());
  } else if (request.has_experiment() && options_.experiment) {
    answer(id, request.id(), options_.experiment(id, viewer.rights.control, request.experiment()));
  }
}

void Hub::refuse(ViewerId id, std::uint64_t request_id, v1::Result why) {
  ++counters_.refused;
  answer(id, request_id, std::move(why));
}

void Hub::steer(ViewerId id, const Viewer& viewer, std::uint64_t request_id,
                const v1::PagePlayback& wanted) {
  if (!viewer.rights.steer) {
    refuse(id, request_id, only_looks());
  } else if (options_.steer) {
    options_.steer(wanted);
  }
}

void Hub::list(ViewerId id, const Viewer& viewer, std::uint64_t request_id) {
  if (!viewer.rights.control) return refuse(id, request_id, only_looks());
  v1::Result result = result_of(v1::RESULT_CODE_OK);
  if (options_.recordings) *result.mutable_listing() = options_.recordings();
  answer(id, request_id, std::move(result));
}

void Hub::show(ViewerId id, const Viewer& viewer, std::uint64_t request_id,
               const v1::PageShow& wanted) {
  if (const auto refused = desk_.refuse_show(id, viewer.rights.control)) {
    refuse(id, request_id, *refused);
  } else if (options_.show) {
    options_.show(wanted.recording(), [this, id, request_id](const v1::Result& result) {
      answer(id, request_id, result);
    });
  }
}

void Hub::call(ViewerId id, Viewer& viewer, std::uint64_t request_id, const v1::Item& item) {
  auto refused = desk_.refuse(id, viewer.rights.control, item);
  if (!refused.has_value() && viewer.under_way >= kMaxUnderWay) {
    refused = result_of(v1::RESULT_CODE_BUSY, "", "this page has too many requests under way");
  }
  if (refused.has_value()) return refuse(id, request_id, *std::move(refused));
  ++viewer.under_way;
  desk_.asked(id, item);
  const auto done = [this, id, request_id, item](const v1::Result* result) {
    const auto asker = viewers_.find(id);
    desk_.answered(id, item, result);
    if (asker == viewers_.end()) {
      // It closed while its Acquire was on the way: nobody would give the lease back.
      if (desk_.holder() == id) give_back_lease();
      return;
    }
    --asker->second.under_way;
    answer(id, request_id,
           result != nullptr ? *result
                             : result_of(v1::RESULT_CODE_FAILED, "",
                                         "the session with the daemon ended before its answer"));
  };
  if (options_.call && options_.call(item, done)) return;
  --viewer.under_way;
  desk_.answered(id, item, nullptr);
  refuse(id, request_id, result_of(v1::RESULT_CODE_FAILED, "", "no daemon answers now"));
}

void Hub::answer(ViewerId id, std::uint64_t request_id, v1::Result result) {
  const auto found = viewers_.find(id);
  if (found == viewers_.end()) return;
  result.set_item_id(request_id);
  v1::PageEvent event;
  *event.mutable_result() = std::move(result);
  put(found->second, body_of(std::move(event)));
}

std::uint64_t Hub::total_dropped() const {
  std::uint64_t total = counters_.dropped_states;
  for (const auto& [id, viewer] : viewers_) total += viewer.queue.dropped_states();
  return total;
}

}  // namespace hapticd::web
