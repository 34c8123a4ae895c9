// See attachment.h.
#include "device/attach/attachment.h"

#include <poll.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <new>
#include <stdexcept>
#include <utility>

#include "core/rt/memory_boundary.h"
#include "core/rt/thread_role.h"

namespace hapticd {
namespace {

/// Between two looks at a device that may have failed, ms: what is lost of a session resumes later.
constexpr int kLook_ms = 20;
/// Looks between two attempts to attach where nobody tells of devices plugged in.
constexpr int kLooksPerTry = 25;

}  // namespace

std::vector<HidrawNode> find_nodes(const IsMine& mine) {
  std::vector<HidrawNode> found = list_hidraw_nodes();
  std::erase_if(found, [&](const HidrawNode& node) { return !mine(node); });
  return found;
}

HidrawNode find_node(const IsMine& mine, const std::string& serial, const std::string& kind) {
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

Attachment::Attachment(Plug& plug, IsMine mine, const HidrawNode& node,
                       std::unique_ptr<HidrawHandles> handles)
    : plug_(plug), mine_(std::move(mine)), serial_(node.serial), handles_(std::move(handles)) {
  attach(node);
  thread_ = std::thread([this] { run(); });
}

Attachment::~Attachment() {
  ending_.store(true);
  thread_.join();
  plug_.detach();
}

std::string Attachment::port() const {
  const std::lock_guard lock(port_mutex_);
  return port_;
}

void Attachment::tell_port(const std::string& port) {
  const std::lock_guard lock(port_mutex_);
  port_ = port;
}

void Attachment::attach(const HidrawNode& node) {
  const std::string warning = plug_.attach(node, handles_->channel());
  if (!warning.empty()) spdlog::warn("{}: {}", describe(node), warning);
  tell_port(describe(node));
}

void Attachment::let_go() {
  plug_.detach();
  handles_.reset();
  told_.clear();
  spdlog::warn("{}: unplugged", port());
  tell_port("unplugged");
}

void Attachment::try_again() {
  const std::vector<HidrawNode> found = find_nodes(mine_);
  const auto node = std::find_if(found.begin(), found.end(),
                                 [&](const HidrawNode& each) { return each.serial == serial_; });
  if (node == found.end()) return;
  try {
    handles_ = std::make_unique<HidrawHandles>(*node);
    attach(*node);
    spdlog::info("{}: plugged in again", port());
  } catch (const std::bad_alloc&) {
    plug_.detach();
    handles_.reset();
    throw;
  } catch (const DeviceError& error) {
    handles_.reset();
    if (told_ != error.what()) spdlog::warn("{}", error.what());
    told_ = error.what();
  }
}

void Attachment::run() {
  begin_role(ThreadRole::kAttachment);
  int looks = 0;
  while (!ending_.load()) {
    pollfd waiting{monitor_.file(), POLLIN, 0};
    const bool told = poll(&waiting, 1, kLook_ms) > 0;
    if (told) monitor_.drain();
    const bool try_now = told || ++looks % kLooksPerTry == 0;
    within_memory([&] {
      if (handles_ && plug_.failed()) let_go();
      if (handles_) plug_.tend([this] { return handles_->features(); });
      if (!handles_ && try_now) try_again();
    });
  }
}

}  // namespace hapticd
