// See attach.h.
#include "device/attach/attach.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace hapticd {
namespace {

void require(const DeviceSheet& sheet, const AttachOptions& options) {
  const std::string fault = options.fault ? options.fault(sheet) : "";
  if (!fault.empty()) {
    throw std::runtime_error("what the device states of itself is not a valid profile: " + fault);
  }
}

/// Checks and limits a device that pushes.
DeviceGrant grant(const HidrawNode& node, const DeviceStatement& statement,
                  const AttachOptions& options, AttachedDevice& attached) {
  require(statement.sheet, options);
  attached.sheet = statement.sheet;
  attached.check = check_of(node, statement, options.checks);
  if (!attached.check->passed()) {
    limit(attached.sheet, &DeviceProfile::peak_force, kUncheckedForce,
          "nobody has checked its axes and signs");
    require(attached.sheet, options);
  }
  return {attached.sheet, std::min(options.max_force, attached.sheet.profile.peak_force)};
}

}  // namespace

AttachedDevice attach_device(const DeviceSource& source, const DeviceSheet& chosen,
                             const AttachOptions& options) {
  const DriverEntry* const driver = source.driver;
  const auto mine = [driver](const HidrawNode& node) { return driver_for(node) == driver; };
  const HidrawNode node = find_node(mine, source.argument, std::string(driver->kind));
  auto handles = std::make_unique<HidrawHandles>(node);
  AttachedDevice attached;
  attached.sheet = chosen;
  double force = 0.0;
  const FoundDevice found{node, handles->channel(), chosen, options.installed,
                          [&](const DeviceStatement& statement) {
                            DeviceGrant granted = grant(node, statement, options, attached);
                            force = granted.force;
                            return granted;
                          }};
  attached.open = driver->open(found);
  if (attached.check == nullptr && driver->traits.can_push_a_person) {
    throw std::logic_error("the driver " + std::string(driver->kind) + " has asked for no grant");
  }
  for (const std::string& warning : attached.open.warnings) {
    spdlog::warn("{}: {}", describe(node), warning);
  }
  if (attached.check != nullptr) {
    spdlog::info("{}: force limited to {} N{}", describe(node), force,
                 attached.check->passed() ? "" : " until it is checked: hapticctl device check");
  }
  attached.attachment =
      std::make_unique<Attachment>(*attached.open.plug, mine, node, std::move(handles));
  return attached;
}

}  // namespace hapticd
