// See announcement.h.
#include "server/service/announcement.h"

#include <avahi-client/client.h>
#include <avahi-client/publish.h>
#include <avahi-common/alternative.h>
#include <avahi-common/error.h>
#include <avahi-common/malloc.h>
#include <avahi-common/thread-watch.h>
#include <spdlog/spdlog.h>

#include <string>

namespace hapticd {

// All but construction and destruction runs on the thread of `poll`.
struct Announcement::Implementation {
  Announced what;
  std::string name;
  AvahiThreadedPoll* poll = nullptr;
  AvahiClient* client = nullptr;
  AvahiEntryGroup* group = nullptr;

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
    if (error != AVAHI_OK) spdlog::warn("not announced: {}", avahi_strerror(error));
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

  static void on_group(AvahiEntryGroup* group, AvahiEntryGroupState state, void* self_of) {
    auto& self = *static_cast<Implementation*>(self_of);
    if (state == AVAHI_ENTRY_GROUP_ESTABLISHED) {
      spdlog::info("announced as '{}', {}", self.name, kServiceType);
    } else if (state == AVAHI_ENTRY_GROUP_COLLISION) {
      self.rename();
      self.publish(avahi_entry_group_get_client(group));
    } else if (state == AVAHI_ENTRY_GROUP_FAILURE) {
      spdlog::warn("not announced: {}",
                   avahi_strerror(avahi_client_errno(avahi_entry_group_get_client(group))));
    }
  }

  static void on_client(AvahiClient* client, AvahiClientState state, void* self_of) {
    auto& self = *static_cast<Implementation*>(self_of);
    switch (state) {
      case AVAHI_CLIENT_S_RUNNING:
        self.publish(client);
        break;
      case AVAHI_CLIENT_S_COLLISION:
      case AVAHI_CLIENT_S_REGISTERING:
        if (self.group != nullptr) avahi_entry_group_reset(self.group);
        break;
      case AVAHI_CLIENT_CONNECTING:
        spdlog::warn(
            "not announced yet: avahi-daemon does not run. Install or start avahi-daemon.");
        break;
      case AVAHI_CLIENT_FAILURE:
        self.lose(client);
        break;
    }
  }

  /// avahi-daemon has gone: waits for the next one.
  void lose(AvahiClient* lost) {
    const int error = avahi_client_errno(lost);
    forget();
    if (client == nullptr) return;  // it is still being made
    spdlog::warn("no longer announced: {}", avahi_strerror(error));
    avahi_client_free(client);
    client = nullptr;
    connect();
  }

  void connect() {
    int error = 0;
    client = avahi_client_new(avahi_threaded_poll_get(poll), AVAHI_CLIENT_NO_FAIL, on_client, this,
                              &error);
    if (client != nullptr) return;
    spdlog::warn("not announced: {}. Install avahi-daemon and start hapticd again.",
                 avahi_strerror(error));
  }
};

Announcement::Announcement(const Announced& what)
    : implementation_(std::make_unique<Implementation>()) {
  Implementation& self = *implementation_;
  self.what = what;
  self.poll = avahi_threaded_poll_new();
  if (self.poll == nullptr) return;
  self.connect();
  avahi_threaded_poll_start(self.poll);
}

Announcement::~Announcement() {
  Implementation& self = *implementation_;
  if (self.poll == nullptr) return;
  avahi_threaded_poll_stop(self.poll);
  self.forget();
  if (self.client != nullptr) avahi_client_free(self.client);
  avahi_threaded_poll_free(self.poll);
}

}  // namespace hapticd
