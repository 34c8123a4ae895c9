// See broker.h.
#include "clients/relay/broker.h"

#include <mosquitto.h>

#include <chrono>
#include <stdexcept>

namespace hapticd::relay {
namespace {

/// Silence after which the broker is asked whether it lives, s.
constexpr int kKeepAlive_s = 10;
/// How long the thread waits at once, ms, and how often until the broker is tried again.
constexpr int kLook_ms = 100;
constexpr int kLooksBetween = 5;
/// A topic has 65535 bytes at most; what follows the prefix is shorter than the rest.
constexpr std::size_t kMostPrefixBytes = 65'000;

void require(int code, const char* what) {
  if (code == MOSQ_ERR_SUCCESS) return;
  throw std::runtime_error(std::string(what) + ": " + mosquitto_strerror(code));
}

}  // namespace

std::string prefix_problem(const std::string& prefix) {
  if (prefix.empty()) return "it is empty. Give what all topics begin with, as hapticd";
  if (mosquitto_validate_utf8(prefix.data(), static_cast<int>(prefix.size())) != MOSQ_ERR_SUCCESS) {
    return "it is not text in UTF-8, or has control characters. Write it in letters, digits and "
           "'/'";
  }
  if (prefix.find_first_of("#+") != std::string::npos) {
    return "'" + prefix +
           "' has '#' or '+', which stand for any topic where somebody listens. Leave them out";
  }
  if (prefix.size() > kMostPrefixBytes) return "it is longer than a topic may be. Shorten it";
  return {};
}

/// libmosquitto's, which is begun before the first handle and ended after the last.
struct Broker::Handle {
  mosquitto* client = nullptr;
};

void Broker::Free::operator()(Handle* handle) const {
  if (handle->client != nullptr) mosquitto_destroy(handle->client);
  mosquitto_lib_cleanup();
  delete handle;
}

Broker::Broker(const BrokerOptions& options) {
  mosquitto_lib_init();
  handle_.reset(new Handle);
  mosquitto* const client = handle_->client = mosquitto_new(nullptr, true, this);
  if (client == nullptr) throw std::runtime_error("no memory for a connection to the broker");
  mosquitto_connect_callback_set(client, [](mosquitto*, void* self, int code) {
    Broker& broker = *static_cast<Broker*>(self);
    broker.refusal_ = code;
    if (code != 0) return;
    broker.connected_ = true;
    ++broker.connections_;
  });
  mosquitto_disconnect_callback_set(
      client, [](mosquitto*, void* self, int) { static_cast<Broker*>(self)->connected_ = false; });
  if (!options.user.empty()) {
    require(mosquitto_username_pw_set(client, options.user.c_str(), options.password.c_str()),
            "--user");
  }
  if (!options.certificates.empty()) {
    require(
        mosquitto_tls_set(client, options.certificates.c_str(), nullptr, nullptr, nullptr, nullptr),
        "--cafile");
  }
  const Publication& will = options.will;
  require(mosquitto_will_set(client, will.topic.c_str(), static_cast<int>(will.payload.size()),
                             will.payload.data(), will.qos, will.retained),
          "--prefix");
  require(mosquitto_threaded_set(client, true), "threads");
  // A broker that is not there is not an error: the thread tries again, which the library's own
  // does not where the very first attempt fails.
  (void)mosquitto_connect_async(client, options.host.c_str(), options.port, kKeepAlive_s);
  thread_ = std::thread([this] { serve(); });
}

void Broker::serve() {
  while (!ends_) {
    if (mosquitto_loop(handle_->client, kLook_ms, 1) == MOSQ_ERR_SUCCESS) continue;
    connected_ = false;
    for (int look = 0; look < kLooksBetween && !ends_; ++look) {
      std::this_thread::sleep_for(std::chrono::milliseconds(kLook_ms));
    }
    if (!ends_) (void)mosquitto_reconnect(handle_->client);
  }
}

Broker::~Broker() {
  (void)mosquitto_disconnect(handle_->client);
  ends_ = true;
  thread_.join();
}

std::string Broker::refusal() const {
  const int code = refusal_;
  return code == 0 ? "" : mosquitto_connack_string(code);
}

bool Broker::publish(const Publication& publication) {
  if (!connected_) return false;
  return mosquitto_publish(handle_->client, nullptr, publication.topic.c_str(),
                           static_cast<int>(publication.payload.size()), publication.payload.data(),
                           publication.qos, publication.retained) == MOSQ_ERR_SUCCESS;
}

}  // namespace hapticd::relay
