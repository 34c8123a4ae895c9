// See gateway.h.
#include "clients/web/gateway/gateway.h"

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/address.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <optional>
#include <utility>

#include "clients/library/client.h"
#include "clients/library/patience.h"
#include "clients/library/program.h"
#include "clients/web/gateway/access.h"
#include "clients/web/gateway/experiment_link.h"
#include "clients/web/gateway/metrics.h"
#include "clients/web/gateway/recording_source.h"
#include "clients/web/gateway/stop_errand.h"
#include "proto/wire/request_result.h"
#include "proto/wire/shown_text.h"

namespace hapticd::web {
namespace {

namespace asio = boost::asio;
using boost::system::error_code;

/// How often the state of the link is looked at, and how many looks make a report.
constexpr std::chrono::milliseconds kLook{100};
constexpr int kLooksPerReport = 10;
/// Time for goodbyes at the end.
constexpr std::chrono::milliseconds kFarewell{300};

}  // namespace

/// The parts, in the order in which they are made.
class Gateway::Implementation {
 public:
  explicit Implementation(WebOptions given);

 private:
  friend Gateway;

  HubOptions hub_options();
  ServerOptions server_options();
  void open_source(const WebOptions& given);
  bool call(const v1::Item& item, client::ResultHandler done);
  void stop_by_session(const client::ResultHandler& done);
  void look();
  void ask_counts();
  void report(const v1::PageLink& now);
  void tell_silence();
  std::string metrics();
  void say_goodbye();

  WebOptions options_;
  std::string token_;
  std::optional<v1::State> newest_;
  v1::Counts counts_;  ///< newest; of an earlier daemon none
  v1::PageLink last_link_;
  int looks_ = 0;
  client::Patience patience_{client::monotonic_now_ns()};
  std::shared_ptr<DaemonLink> link_;
  std::unique_ptr<ExperimentLink> experiments_;
  // Whoever is still connected at the end refers to the hub from inside the context.
  Hub hub_;
  asio::io_context context_{1};
  asio::steady_timer link_timer_{context_};
  asio::steady_timer farewell_timer_{context_};
  asio::signal_set signals_{context_};
  HttpServer server_;
  RecordingSource recordings_;
  std::unique_ptr<StopErrand> stop_;  ///< null: a recording is the source
};

Gateway::Implementation::Implementation(WebOptions given)
    : options_(std::move(given)),
      token_(!options_.recording.empty() || !options_.link.key.has_value() ||
                     options_.link.key->role == wire::Role::kControl
                 ? make_token()
                 : ""),
      hub_(hub_options()),
      server_(context_, server_options(), hub_),
      recordings_(context_, hub_, RecordingFolder(options_.recordings),
                  [this](const v1::State& state) {
                    // With a daemon the metrics are its own.
                    if (link_ == nullptr) newest_ = state;
                  }) {
  experiments_ = std::make_unique<ExperimentLink>(
      context_, options_.experiments, [this](const v1::ExperimentScreen& screen, ViewerId owner) {
        hub_.experiment(screen, owner);
      });
  open_source(options_);
}

HubOptions Gateway::Implementation::hub_options() {
  HubOptions made;
  made.version = HAPTICD_VERSION;
  made.presentation_delay_s = options_.presentation_delay_s;
  made.call = [this](const v1::Item& item, client::ResultHandler done) {
    return call(item, std::move(done));
  };
  made.steer = [this](const v1::PagePlayback& wanted) { recordings_.steer(wanted); };
  made.show = [this](const std::string& name, Answer done) {
    recordings_.show(name, std::move(done));
  };
  made.recordings = [this] { return recordings_.list(); };
  made.experiment = [this](ViewerId viewer, bool control, const v1::PageExperiment& asked) {
    return experiments_->take(viewer, control, asked);
  };
  made.gone = [this](ViewerId viewer) {
    if (experiments_ != nullptr) experiments_->gone(viewer);
  };
  made.daemon_now_ns = [this]() -> std::int64_t {
    if (const auto shown_ns = recordings_.shown_t_ns()) return *shown_ns;
    return link_ != nullptr ? link_->daemon_now_ns() : 0;
  };
  return made;
}

// A Stop goes by the Stop road, whatever the session's thread in the daemon does.
bool Gateway::Implementation::call(const v1::Item& item, client::ResultHandler done) {
  if (item.has_stop() && stop_ != nullptr) {
    stop_->run(std::move(done));
    return true;
  }
  return link_ != nullptr && link_->request(item, std::move(done));
}

void Gateway::Implementation::stop_by_session(const client::ResultHandler& done) {
  v1::Item item;
  item.mutable_stop();
  if (link_ != nullptr && link_->request(item, done)) return;
  const v1::Result failed = wire::result_of(v1::RESULT_CODE_FAILED, "", "no daemon answers now");
  if (done) done(&failed);
}

ServerOptions Gateway::Implementation::server_options() {
  ServerOptions made = options_.server;
  made.token = token_;
  made.control = options_.recording.empty();
  made.assets = options_.assets;
  made.metrics = [this] { return metrics(); };
  return made;
}

void Gateway::Implementation::open_source(const WebOptions& given) {
  if (!given.recording.empty()) {
    recordings_.open(given.recording);
    return;
  }
  LinkHandlers told;
  told.state = [this](const v1::State& state) {
    newest_ = state;
    hub_.state(state);
  };
  told.item = [this](const v1::Item& item) {
    if (item.has_scene_info()) {
      stop_->look_at(static_cast<std::uint16_t>(item.scene_info().stop_port()));
    }
    hub_.item(item);
  };
  told.ended = [this] {
    newest_.reset();
    hub_.session_ended();
  };
  stop_ = std::make_unique<StopErrand>(
      context_, given.stop, [this](const client::ResultHandler& done) { stop_by_session(done); });
  link_ = std::make_shared<DaemonLink>(context_, given.link, std::move(told));
}

void Gateway::Implementation::look() {
  ++looks_;
  if (looks_ >= kLooksPerReport) {
    looks_ = 0;
    report(link_->report());
    ask_counts();
  } else if (link_->verdict().state != last_link_.state()) {
    v1::PageLink changed = last_link_;
    const LinkVerdict verdict = link_->verdict();
    changed.set_state(verdict.state);
    changed.set_message(verdict.message);
    report(changed);
  }
  tell_silence();
  link_timer_.expires_after(kLook);
  link_timer_.async_wait([this](const error_code& cancelled) {
    if (!cancelled) look();
  });
}

void Gateway::Implementation::ask_counts() {
  v1::Item item;
  item.mutable_get_counts();
  link_->request(item, [this](const v1::Result* result) {
    if (result != nullptr && result->has_counts()) counts_ = result->counts();
  });
}

void Gateway::Implementation::report(const v1::PageLink& now) {
  last_link_ = now;
  hub_.link(now);
}

/// Pages show the verdict all the time; who started this program sees it once.
void Gateway::Implementation::tell_silence() {
  const LinkVerdict now = link_->verdict();
  if (!patience_.ends(now.state == v1::PAGE_LINK_STATE_LIVE, client::monotonic_now_ns())) return;
  const bool silent =
      now.state == v1::PAGE_LINK_STATE_DAEMON_GONE || now.state == v1::PAGE_LINK_STATE_WRONG_KEY;
  // The lab's address of the daemon is that of the link.
  const std::string text =
      silent ? client::unanswered(options_.experiments.address) : now.message + ".";
  std::fprintf(stderr, "haptic-web: %s\n", wire::shown_lines(text).c_str());
}

std::string Gateway::Implementation::metrics() {
  Metrics told;
  told.version = HAPTICD_VERSION;
  told.viewers = hub_.viewers();
  told.hub = hub_.counters();
  told.dropped_states = hub_.total_dropped();
  told.server = server_.counters();
  told.link = last_link_;
  if (link_ != nullptr) {
    told.received_bytes = link_->received_bytes();
    told.sessions_ended = link_->sessions_ended();
  }
  told.state = newest_;
  told.counts = counts_;
  return metrics_text(told);
}

void Gateway::Implementation::say_goodbye() {
  server_.stop();
  hub_.close_all();
  if (link_ != nullptr) link_->stop();
  link_timer_.cancel();
  recordings_.stop();
  experiments_->stop();
  farewell_timer_.expires_after(kFarewell);
  farewell_timer_.async_wait([this](const error_code&) { context_.stop(); });
}

Gateway::Gateway(WebOptions options)
    : implementation_(std::make_unique<Implementation>(std::move(options))) {}

Gateway::~Gateway() {
  // Viewers that are still there give back the lease while they go.
  if (implementation_->link_ != nullptr) implementation_->link_->stop();
  implementation_->link_.reset();
  // What it runs ends with its input.
  implementation_->experiments_.reset();
}

void Gateway::run() {
  Implementation& mine = *implementation_;
  mine.server_.start();
  if (mine.link_ != nullptr) {
    mine.link_->start();
    mine.looks_ = kLooksPerReport;
    mine.look();
  }
  mine.context_.run();
}

void Gateway::stop() {
  asio::post(implementation_->context_, [this] { implementation_->say_goodbye(); });
}

void Gateway::stop_on_signals() {
  implementation_->signals_.add(SIGINT);
  implementation_->signals_.add(SIGTERM);
  implementation_->signals_.async_wait([this](const error_code& cancelled, int) {
    if (!cancelled) implementation_->say_goodbye();
  });
}

std::uint16_t Gateway::port() const { return implementation_->server_.port(); }

const std::string& Gateway::token() const { return implementation_->token_; }

std::string Gateway::invitation() const {
  const ServerOptions& server = implementation_->options_.server;
  const bool tls = !server.certificate.empty();
  const std::string scheme = tls ? "https://" : "http://";
  const std::string end = ":" + std::to_string(port()) + "/";
  error_code unknown;
  const auto address = asio::ip::make_address(server.address, unknown);
  const bool everywhere = address.is_unspecified();
  const std::string shown =
      everywhere ? "localhost" : (address.is_v6() ? "[" + server.address + "]" : server.address);
  const bool control = !token().empty() && (tls || everywhere || address.is_loopback());
  std::string text = "Open " + scheme + shown + end + (control ? "#token=" + token() : "") + "\n";
  if (everywhere || !address.is_loopback()) {
    const std::string there = everywhere ? "HOST" : shown;
    text += "From another machine: " + scheme + there + end;
    if (tls && control) text += "#token=" + token();
    text += tls ? "\n" : " to look; control from there needs --cert and --key-file\n";
  }
  return text;
}

}  // namespace hapticd::web
