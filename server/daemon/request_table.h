// Which desk carries out which request, and what is refused whatever the desk. Not RT.
#pragma once

#include "server/daemon/asset_desk.h"
#include "server/daemon/catalogues.h"
#include "server/daemon/daemon_time.h"
#include "server/daemon/device_desk.h"
#include "server/daemon/play_desk.h"
#include "server/daemon/record_desk.h"

namespace hapticd {

/// Those who carry out requests. All outlive the table.
struct Desks {
  LoopDesk& loop;
  AssetDesk& assets;
  SceneDesk& scenes;
  PlayDesk& play;
  RecordDesk& records;
  DeviceDesk& devices;
  Catalogues& catalogues;
  DaemonTime& time;
};

class RequestTable {
 public:
  RequestTable(const Desks& desks, ServedClients& clients) : desks_(desks), clients_(clients) {}

  /// Carries out a request that rights and lease permit, and answers it, now or later.
  void carry_out(const RequestId& id, const v1::Item& item);
  /// Nobody waits for the answer any more.
  void abandon(const RequestId& id);

 private:
  [[nodiscard]] Answer answer_to(const RequestId& id, const v1::Item& item);

  Desks desks_;
  ServedClients& clients_;
};

}  // namespace hapticd
