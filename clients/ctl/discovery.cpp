// See discovery.h.
#include "clients/ctl/discovery.h"

#include <avahi-client/client.h>
#include <avahi-client/lookup.h>
#include <avahi-common/address.h>
#include <avahi-common/error.h>
#include <avahi-common/malloc.h>
#include <avahi-common/simple-watch.h>
#include <avahi-common/strlst.h>
#include <net/if.h>

#include <algorithm>
#include <array>
#include <memory>
#include <set>

#include "clients/ctl/connection.h"

namespace hapticd::ctl {
namespace {

constexpr const char* kServiceType = "_hapticd._udp";
/// More are not listed: whoever floods the network does not fill the memory.
constexpr std::size_t kMaxFound = 256;
constexpr std::size_t kMaxText = 128;
/// Between two looks at the clock.
constexpr int kTurn_ms = 50;

/// The value of `key` in a TXT record; empty: there is none.
std::string value_of(AvahiStringList* txt, const char* key) {
  AvahiStringList* const entry = avahi_string_list_find(txt, key);
  char* name = nullptr;
  char* value = nullptr;
  if (entry == nullptr || avahi_string_list_get_pair(entry, &name, &value, nullptr) != 0) return {};
  std::string text = value == nullptr ? "" : value;
  avahi_free(name);
  avahi_free(value);
  return text;
}

std::string address_text(const AvahiAddress& address, AvahiIfIndex interface) {
  std::array<char, AVAHI_ADDRESS_STR_MAX> text{};
  avahi_address_snprint(text.data(), text.size(), &address);
  std::array<char, IF_NAMESIZE> zone{};
  const bool link_local = address.proto == AVAHI_PROTO_INET6 &&
                          address.data.ipv6.address[0] == 0xfe &&
                          (address.data.ipv6.address[1] & 0xc0U) == 0x80;
  if (!link_local || ::if_indextoname(static_cast<unsigned>(interface), zone.data()) == nullptr) {
    return text.data();
  }
  return std::string(text.data()) + "%" + zone.data();
}

/// A service as avahi-daemon names it.
struct Named {
  AvahiIfIndex interface;
  AvahiProtocol protocol;
  const char* name;
  const char* type;
  const char* domain;
};

/// What a service has turned out to be.
struct Resolved {
  AvahiIfIndex interface;
  const char* name;
  const char* host;
  const AvahiAddress* address;
  std::uint16_t port;
  AvahiStringList* txt;
};

FoundDaemon daemon_of(const Resolved& what) {
  FoundDaemon daemon;
  daemon.name = printable(what.name);
  daemon.host = printable(what.host);
  daemon.address = address_text(*what.address, what.interface);
  daemon.port = what.port;
  daemon.keys = value_of(what.txt, "keys") == "required";
  const std::string protocol = value_of(what.txt, "protocol");
  const auto digit = [](char c) { return c >= '0' && c <= '9'; };
  const bool number = protocol.size() < 4 && std::all_of(protocol.begin(), protocol.end(), digit);
  if (number) daemon.protocol = protocol;
  return daemon;
}

/// One question to avahi-daemon.
class Search {
 public:
  Search() {
    int error = 0;
    if (poll_ == nullptr) throw Failure(kRefused, "avahi: there is no memory");
    client_.reset(avahi_client_new(
        avahi_simple_poll_get(poll_.get()), AvahiClientFlags{},
        [](AvahiClient*, AvahiClientState, void*) {}, nullptr, &error));
    if (client_ != nullptr && !browse()) error = avahi_client_errno(client_.get());
    if (browser_ != nullptr) return;
    throw Failure(kRefused, std::string("nobody can be asked: ") + avahi_strerror(error) +
                                ". Install and start avahi-daemon");
  }

  /// What has been found when all is told, or the time is over.
  std::vector<FoundDaemon> run(std::chrono::nanoseconds patience) {
    const auto end = std::chrono::steady_clock::now() + patience;
    while ((!told_ || resolving_ > 0) && std::chrono::steady_clock::now() < end) {
      if (avahi_simple_poll_iterate(poll_.get(), kTurn_ms) != 0) break;
    }
    return {found_.begin(), found_.end()};
  }

 private:
  bool browse() {
    const auto on_browse = [](AvahiServiceBrowser*, AvahiIfIndex interface, AvahiProtocol protocol,
                              AvahiBrowserEvent event, const char* name, const char* type,
                              const char* domain, AvahiLookupResultFlags, void* search) {
      auto& self = *static_cast<Search*>(search);
      if (event == AVAHI_BROWSER_ALL_FOR_NOW || event == AVAHI_BROWSER_FAILURE) self.told_ = true;
      if (event == AVAHI_BROWSER_NEW) self.resolve({interface, protocol, name, type, domain});
    };
    browser_.reset(avahi_service_browser_new(client_.get(), AVAHI_IF_UNSPEC, AVAHI_PROTO_UNSPEC,
                                             kServiceType, nullptr, AvahiLookupFlags{}, on_browse,
                                             this));
    return browser_ != nullptr;
  }

  void resolve(const Named& of) {
    const auto on_resolve = [](AvahiServiceResolver* resolver, AvahiIfIndex interface,
                               AvahiProtocol, AvahiResolverEvent event, const char* name,
                               const char*, const char*, const char* host,
                               const AvahiAddress* address, std::uint16_t port,
                               AvahiStringList* txt, AvahiLookupResultFlags, void* search) {
      auto& self = *static_cast<Search*>(search);
      --self.resolving_;
      if (event == AVAHI_RESOLVER_FOUND && port != 0) {
        self.found_.insert(daemon_of({interface, name, host, address, port, txt}));
      }
      avahi_service_resolver_free(resolver);
    };
    if (asked_ >= kMaxFound) return;
    ++asked_;
    // By the family it was found with: a daemon that listens on IPv4 alone is found by that alone.
    AvahiServiceResolver* const resolver =
        avahi_service_resolver_new(client_.get(), of.interface, of.protocol, of.name, of.type,
                                   of.domain, of.protocol, AvahiLookupFlags{}, on_resolve, this);
    if (resolver != nullptr) ++resolving_;
  }

  template <auto Free>
  struct Freed {
    template <typename Thing>
    void operator()(Thing* thing) const {
      Free(thing);
    }
  };

  // What is declared later goes first. The client frees the resolvers that are left.
  std::unique_ptr<AvahiSimplePoll, Freed<avahi_simple_poll_free>> poll_{avahi_simple_poll_new()};
  std::unique_ptr<AvahiClient, Freed<avahi_client_free>> client_;
  std::unique_ptr<AvahiServiceBrowser, Freed<avahi_service_browser_free>> browser_;
  std::set<FoundDaemon> found_;
  bool told_ = false;
  std::size_t asked_ = 0;
  std::size_t resolving_ = 0;
};

}  // namespace

std::string printable(std::string_view text) {
  std::string shown(text.substr(0, kMaxText));
  for (char& c : shown) {
    if (c < 0x20 || c > 0x7e) c = '?';
  }
  return shown;
}

std::string server_text(const FoundDaemon& found) {
  const bool v6 = found.address.find(':') != std::string::npos;
  return (v6 ? "[" + found.address + "]" : found.address) + ":" + std::to_string(found.port);
}

std::vector<FoundDaemon> discover(std::chrono::nanoseconds patience) {
  return Search().run(patience);
}

}  // namespace hapticd::ctl
