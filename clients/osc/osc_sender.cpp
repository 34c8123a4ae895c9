// See osc_sender.h.
#include "clients/osc/osc_sender.h"

#include <lo/lo.h>
#include <netdb.h>
#include <sys/socket.h>

#include <stdexcept>
#include <type_traits>

namespace hapticd::osc {
namespace {

struct FreeBundle {
  void operator()(lo_bundle bundle) const { lo_bundle_free_recursive(bundle); }
};
using Bundle = std::unique_ptr<std::remove_pointer_t<lo_bundle>, FreeBundle>;

struct Add {
  lo_message message;
  void operator()(std::int32_t number) const { lo_message_add_int32(message, number); }
  void operator()(float number) const { lo_message_add_float(message, number); }
  void operator()(const std::string& text) const { lo_message_add_string(message, text.c_str()); }
};

}  // namespace

struct OscSender::Implementation {
  struct FreeAddress {
    void operator()(lo_address unused) const { lo_address_free(unused); }
  };
  std::unique_ptr<std::remove_pointer_t<lo_address>, FreeAddress> address;
};

OscSender::OscSender(const std::string& host, std::uint16_t port)
    : implementation_(std::make_unique<Implementation>()) {
  // liblo looks the name up when it sends, and says nothing.
  addrinfo wanted{};
  wanted.ai_socktype = SOCK_DGRAM;
  addrinfo* found = nullptr;
  const bool known = getaddrinfo(host.c_str(), nullptr, &wanted, &found) == 0;
  if (known) freeaddrinfo(found);
  implementation_->address.reset(lo_address_new(host.c_str(), std::to_string(port).c_str()));
  if (!known || implementation_->address == nullptr) {
    throw std::runtime_error("--to: there is no machine called " + host);
  }
}

OscSender::~OscSender() = default;

bool OscSender::send(const OscMessage& message, const TimeTag& when) {
  const Bundle bundle(lo_bundle_new(lo_timetag{when.seconds, when.fraction}));
  lo_message built = lo_message_new();
  for (const OscArgument& argument : message.arguments) std::visit(Add{built}, argument);
  lo_bundle_add_message(bundle.get(), message.path.c_str(), built);
  return lo_send_bundle(implementation_->address.get(), bundle.get()) > 0;
}

}  // namespace hapticd::osc
