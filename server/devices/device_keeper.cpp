// See device_keeper.h.
#include "server/devices/device_keeper.h"

#include <poll.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace hapticd {
namespace {

/// Between two looks at a device that may have failed, ms: what is lost of a session resumes later.
constexpr int kLook_ms = 20;
/// Looks between two attempts to attach where nobody tells of devices plugged in.
constexpr int kLooksPerTry = 25;

}  // namespace

std::vector<HidrawNode> find_nodes(const std::function<bool(const HidrawNode&)>& mine) {
  std::vector<HidrawNode> found = list_hidraw_nodes();
  std::erase_if(found, [&](const HidrawNode& node) { return !mine(node); });
  return found;
}

HidrawNode find_node(const std::function<bool(const HidrawNode&)>& mine, const std::string& serial,
                     const std::string& kind) {
  std::vector<HidrawNode> found = find_nodes(mine);
  std::string others;
  for (const HidrawNode& node : found) others += (others.empty() ? "" : ", ") + describe(node);
  if (!serial.empty()) {
    std::erase_if(found, [&](const HidrawNode& node) { return node.serial != serial; });
  }
  if (found.size() == 1) return std::move(found.front());
  if (found.size() > 1) {
    throw std::runtime_error("there are several: " + others + ". Name one by its serial, as in " +
                             kind + ":SERIAL.");
  }
  throw std::runtime_error("no " + kind + " device" +
                           (serial.empty() ? "" : " of serial " + serial) + " is plugged in" +
                           (others.empty() ? "" : "; there is " + others) +
                           ". Plug it in, or choose --device simulated.");
}

DeviceKeeper::DeviceKeeper(KeptDriver driver, const HidrawNode& node,
                           std::unique_ptr<HidrawHandles> handles)
    : driver_(std::move(driver)), serial_(node.serial), handles_(std::move(handles)) {
  driver_.attach(node, handles_->channel());
  tell_port(describe(node));
  thread_ = std::thread([this] { run(); });
}

DeviceKeeper::~DeviceKeeper() {
  ending_.store(true);
  thread_.join();
  driver_.detach();
}

std::string DeviceKeeper::port() const {
  const std::lock_guard lock(port_mutex_);
  return port_;
}

void DeviceKeeper::tell_port(const std::string& port) {
  const std::lock_guard lock(port_mutex_);
  port_ = port;
}

void DeviceKeeper::let_go() {
  driver_.detach();
  handles_.reset();
  told_.clear();
  spdlog::warn("{}: unplugged", port());
  tell_port("unplugged");
}

void DeviceKeeper::try_again() {
  const std::vector<HidrawNode> found = find_nodes(driver_.mine);
  const auto node = std::find_if(found.begin(), found.end(),
                                 [&](const HidrawNode& each) { return each.serial == serial_; });
  if (node == found.end()) return;
  try {
    handles_ = std::make_unique<HidrawHandles>(*node);
    driver_.attach(*node, handles_->channel());
    tell_port(describe(*node));
    spdlog::info("{}: plugged in again", port());
  } catch (const DeviceError& error) {
    handles_.reset();
    if (told_ != error.what()) spdlog::warn("{}", error.what());
    told_ = error.what();
  }
}

void DeviceKeeper::run() {
  int looks = 0;
  while (!ending_.load()) {
    pollfd waiting{monitor_.file(), POLLIN, 0};
    const bool told = poll(&waiting, 1, kLook_ms) > 0;
    if (told) monitor_.drain();
    if (handles_ && driver_.failed()) let_go();
    if (handles_ && driver_.tend) driver_.tend(*handles_);
    if (!handles_ && (told || ++looks % kLooksPerTry == 0)) try_again();
  }
}

}  // namespace hapticd
