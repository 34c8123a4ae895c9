// See gateway.h.
#include "clients/web/gateway/gateway.h"

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/address.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <csignal>
#include <optional>
#include <utility>

#include "clients/library/client.h"
#include "clients/web/gateway/access.h"
#include "clients/web/gateway/asset_store.h"
#include "clients/web/gateway/experiment_link.h"
#include "clients/web/gateway/metrics.h"
#include "clients/web/gateway/recording_source.h"

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

struct Gateway::Implementation {
  explicit Implementation(WebOptions given);

  HubOptions hub_options();
  ServerOptions server_options();
  void open_source(const WebOptions& options);
  void look();
  void report(const v1::PageLink& link);
  std::string metrics();
  void say_goodbye();

  WebOptions options;
  std::string token;
  AssetStore assets;
  std::optional<v1::State> newest;
  v1::PageLink last_link;
  int looks = 0;
  std::shared_ptr<DaemonLink> link;
  std::unique_ptr<ExperimentLink> experiments;
  // Whoever is still connected at the end refers to the hub from inside the context.
  Hub hub;
  asio::io_context context{1};
  asio::steady_timer link_timer{context};
  asio::steady_timer farewell_timer{context};
  asio::signal_set signals{context};
  HttpServer server;
  RecordingSource recordings;
};

Gateway::Implementation::Implementation(WebOptions given)
    : options(std::move(given)),
      token(options.recording.empty() && (!options.link.key.has_value() ||
                                          options.link.key->role == wire::Role::kControl)
                ? make_token()
                : ""),
      assets(options.assets),
      hub(hub_options()),
      server(context, server_options(), hub),
      recordings(context, hub, RecordingFolder(options.recordings), [this](const v1::State& state) {
        // With a daemon the metrics are its own.
        if (link == nullptr) newest = state;
      }) {
  experiments = std::make_unique<ExperimentLink>(
      context, options.experiments, [this](const v1::ExperimentScreen& screen, ViewerId owner) {
        hub.experiment(screen, owner);
      });
  open_source(options);
}

HubOptions Gateway::Implementation::hub_options() {
  HubOptions made;
  made.version = HAPTICD_VERSION;
  made.presentation_delay_s = options.presentation_delay_s;
  made.call = [this](const v1::Item& item, client::ResultHandler done) {
    return link != nullptr && link->request(item, std::move(done));
  };
  made.steer = [this](const v1::PagePlayback& wanted) { recordings.steer(wanted); };
  made.show = [this](const std::string& name, Answer done) {
    recordings.show(name, std::move(done));
  };
  made.recordings = [this] { return recordings.list(); };
  made.experiment = [this](ViewerId viewer, bool control, const v1::PageExperiment& asked) {
    return experiments->take(viewer, control, asked);
  };
  made.gone = [this](ViewerId viewer) {
    if (experiments != nullptr) experiments->gone(viewer);
  };
  made.daemon_now_ns = [this]() -> std::int64_t {
    if (const auto shown_ns = recordings.shown_t_ns()) return *shown_ns;
    return link != nullptr ? link->daemon_now_ns() : 0;
  };
  return made;
}

ServerOptions Gateway::Implementation::server_options() {
  ServerOptions made = options.server;
  made.token = token;
  made.asset = [this](const std::string& hash) {
    return assets.find(hash, client::monotonic_now_ns());
  };
  made.metrics = [this] { return metrics(); };
  return made;
}

void Gateway::Implementation::open_source(const WebOptions& given) {
  if (!given.recording.empty()) {
    recordings.open(given.recording);
    return;
  }
  LinkHandlers told;
  told.state = [this](const v1::State& state) {
    newest = state;
    hub.state(state);
  };
  told.item = [this](const v1::Item& item) { hub.item(item); };
  told.ended = [this] {
    newest.reset();
    hub.session_ended();
  };
  link = std::make_shared<DaemonLink>(context, given.link, std::move(told));
}

void Gateway::Implementation::look() {
  ++looks;
  if (looks >= kLooksPerReport) {
    looks = 0;
    report(link->report());
  } else if (link->verdict().state != last_link.state()) {
    v1::PageLink changed = last_link;
    const LinkVerdict verdict = link->verdict();
    changed.set_state(verdict.state);
    changed.set_message(verdict.message);
    report(changed);
  }
  link_timer.expires_after(kLook);
  link_timer.async_wait([this](const error_code& cancelled) {
    if (!cancelled) look();
  });
}

void Gateway::Implementation::report(const v1::PageLink& now) {
  last_link = now;
  hub.link(now);
}

std::string Gateway::Implementation::metrics() {
  Metrics told;
  told.version = HAPTICD_VERSION;
  told.viewers = hub.viewers();
  told.hub = hub.counters();
  told.dropped_states = hub.total_dropped();
  told.server = server.counters();
  told.link = last_link;
  if (link != nullptr) {
    told.received_bytes = link->received_bytes();
    told.sessions_ended = link->sessions_ended();
  }
  told.state = newest;
  return metrics_text(told);
}

void Gateway::Implementation::say_goodbye() {
  server.stop();
  hub.close_all();
  if (link != nullptr) link->stop();
  link_timer.cancel();
  recordings.stop();
  experiments->stop();
  farewell_timer.expires_after(kFarewell);
  farewell_timer.async_wait([this](const error_code&) { context.stop(); });
}

Gateway::Gateway(WebOptions options)
    : implementation_(std::make_unique<Implementation>(std::move(options))) {}

Gateway::~Gateway() {
  // Viewers that are still there give back the lease while they go.
  if (implementation_->link != nullptr) implementation_->link->stop();
  implementation_->link.reset();
  // What it runs ends with its input.
  implementation_->experiments.reset();
}

void Gateway::run() {
  Implementation& mine = *implementation_;
  mine.server.start();
  if (mine.link != nullptr) {
    mine.link->start();
    mine.looks = kLooksPerReport;
    mine.look();
  }
  mine.context.run();
}

void Gateway::stop() {
  asio::post(implementation_->context, [this] { implementation_->say_goodbye(); });
}

void Gateway::stop_on_signals() {
  implementation_->signals.add(SIGINT);
  implementation_->signals.add(SIGTERM);
  implementation_->signals.async_wait([this](const error_code& cancelled, int) {
    if (!cancelled) implementation_->say_goodbye();
  });
}

std::uint16_t Gateway::port() const { return implementation_->server.port(); }

const std::string& Gateway::token() const { return implementation_->token; }

std::string Gateway::invitation() const {
  const ServerOptions& server = implementation_->options.server;
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
