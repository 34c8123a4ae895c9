// See announcement.h.
#include "server/service/announcement.h"

#include <avahi-client/client.h>
#include <avahi-client/publish.h>
#include <avahi-common/alternative.h>
#include <avahi-common/error.h>
#include <avahi-common/malloc.h>
#include <avahi-common/simple-watch.h>
#include <spdlog/spdlog.h>

#include <atomic>
#include <chrono>
#include <future>
#include <mutex>
#include <string>
#include <thread>

#include "core/rt/memory_boundary.h"
#include "core/rt/thread_role.h"

namespace hapticd {
namespace {

/// Longest wait at the end for a farewell to avahi-daemon.
constexpr std::chrono::milliseconds kFarewell{200};

}  // namespace

// Runs on a thread of its own, since each call of libavahi waits up to 25 s for an avahi-daemon
// that hangs. All that others touch is `poll` to wake it, `over`, and tell's own.
struct Announcement::Implementation {
  Announced what;
  std::string name;
  AvahiSimplePoll* poll = nullptr;
  AvahiClient* client = nullptr;
  AvahiEntryGroup* group = nullptr;
  std::atomic<bool> over{false};
  std::mutex telling;
  bool silent = false;  ///< guarded by `telling`

  explicit Implementation(const Announced& announced)
      : what(announced), poll(avahi_simple_poll_new()) {}
  Implementation(const Implementation&) = delete;
  Implementation& operator=(const Implementation&) = delete;
  ~Implementation() {
    if (poll != nullptr) avahi_simple_poll_free(poll);
  }

  /// Until it is over.
  void run() {
    begin_role(ThreadRole::kAnnouncer);
    within_memory([&] { connect(); });
    while (!over.load() && avahi_simple_poll_iterate(poll, -1) == 0) {
    }
    forget();
    if (client != nullptr) avahi_client_free(client);
    client = nullptr;
  }

  template <typename... Values>
  void tell(spdlog::level::level_enum level, fmt::format_string<Values...> text,
            Values&&... values) {
    const std::lock_guard lock(telling);
    if (!silent) spdlog::log(level, fmt::format(text, std::forward<Values>(values)...));
  }

  /// The log may end from now on.
  void be_silent() {
    const std::lock_guard lock(telling);
    silent = true;
  }

  /// Publishes under `name`.
  void publish(AvahiClient* with) {
    if (name.empty()) name = std::string("hapticd on ") + avahi_client_get_host_name(with);
    if (group == nullptr) group = avahi_entry_group_new(with, on_group, this);
    int error = group == nullptr ? avahi_client_errno(with) : AVAHI_ERR_COLLISION;
    while (group != nullptr && error == AVAHI_ERR_COLLISION) {
      error = add();
      if (error == AVAHI_ERR_COLLISION) rename();
    }
    if (error == AVAHI_OK) error = avahi_entry_group_commit(group);
    if (error != AVAHI_OK) tell(spdlog::level::warn, "not announced: {}", avahi_strerror(error));
  }

  int add() const {
    const AvahiProtocol family = what.ipv4_only ? AVAHI_PROTO_INET : AVAHI_PROTO_UNSPEC;
    const std::string protocol = "protocol=" + std::to_string(what.protocol);
    return avahi_entry_group_add_service(group, AVAHI_IF_UNSPEC, family, AvahiPublishFlags{},
                                         name.c_str(), kServiceType, nullptr, nullptr, what.port,
                                         protocol.c_str(), "keys=required", nullptr);
  }

  void rename() {
    char* const other = avahi_alternative_service_name(name.c_str());
    name = other;
    avahi_free(other);
  }

  void forget() {
    if (group != nullptr) avahi_entry_group_free(group);
    group = nullptr;
  }

  // No exception may cross libavahi, which calls these.
  static void on_group(AvahiEntryGroup* group, AvahiEntryGroupState state, void* self_of) {
    within_memory([&] { static_cast<Implementation*>(self_of)->follow(group, state); });
  }

  static void on_client(AvahiClient* client, AvahiClientState state, void* self_of) {
    within_memory([&] { static_cast<Implementation*>(self_of)->follow(client, state); });
  }

  void follow(AvahiEntryGroup* of, AvahiEntryGroupState state) {
    if (state == AVAHI_ENTRY_GROUP_ESTABLISHED) {
      tell(spdlog::level::info, "announced as '{}', {}", name, kServiceType);
    } else if (state == AVAHI_ENTRY_GROUP_COLLISION) {
      rename();
      publish(avahi_entry_group_get_client(of));
    } else if (state == AVAHI_ENTRY_GROUP_FAILURE) {
      tell(spdlog::level::warn, "not announced: {}",
           avahi_strerror(avahi_client_errno(avahi_entry_group_get_client(of))));
    }
  }

  void follow(AvahiClient* of, AvahiClientState state) {
    switch (state) {
      case AVAHI_CLIENT_S_RUNNING:
        publish(of);
        break;
      case AVAHI_CLIENT_S_COLLISION:
      case AVAHI_CLIENT_S_REGISTERING:
        if (group != nullptr) avahi_entry_group_reset(group);
        break;
      case AVAHI_CLIENT_CONNECTING:
        tell(spdlog::level::warn,
             "not announced yet: avahi-daemon does not run. Install or start avahi-daemon.");
        break;
      case AVAHI_CLIENT_FAILURE:
        lose(of);
        break;
    }
  }

  /// avahi-daemon has gone: waits for the next one.
  void lose(AvahiClient* lost) {
    const int error = avahi_client_errno(lost);
    forget();
    if (client == nullptr) return;  // it is still being made
    tell(spdlog::level::warn, "no longer announced: {}", avahi_strerror(error));
    avahi_client_free(client);
    client = nullptr;
    connect();
  }

  void connect() {
    int error = 0;
    client = avahi_client_new(avahi_simple_poll_get(poll), AVAHI_CLIENT_NO_FAIL, on_client, this,
                              &error);
    if (client != nullptr) return;
    tell(spdlog::level::warn, "not announced: {}. Install avahi-daemon and start hapticd again.",
         avahi_strerror(error));
  }
};

Announcement::Announcement(const Announced& what)
    : implementation_(std::make_shared<Implementation>(what)) {
  if (implementation_->poll == nullptr) return;
  std::packaged_task<void()> task([self = implementation_] { self->run(); });
  finished_ = task.get_future();
  thread_ = std::thread(std::move(task));
}

void Announcement::withdraw() noexcept {
  if (!thread_.joinable()) return;
  implementation_->over.store(true);
  avahi_simple_poll_wakeup(implementation_->poll);
}

Announcement::~Announcement() {
  if (!thread_.joinable()) return;
  withdraw();
  if (finished_.wait_for(kFarewell) == std::future_status::ready) {
    thread_.join();
    return;
  }
  implementation_->be_silent();
  thread_.detach();
}

}  // namespace hapticd
