#pragma once

#include <umockdev.h>

#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

#include "sim_fixtures/u3v/little_endian.h"
#include "sim_fixtures/u3v/usb_function.h"

namespace rigcal::sim {

struct UnrefGObject {
  void operator()(void* object) const { g_object_unref(object); }
};
template <typename T>
using GObjectPointer = std::unique_ptr<T, UnrefGObject>;

/// The device node of an emulated USB device as usbdevfs has it (linux/usbdevice_fs.h): transfers are submitted, reaped
/// and discarded, interfaces claimed. Each program, and each opening of the node, has transfers of its own. A transfer
/// is carried out when it is asked for (reaped), so that none is ever lost between its end and a time-out.
class UsbfsNode : public std::enable_shared_from_this<UsbfsNode> {
 public:
  /// `texts` are the device's, from index 1.
  UsbfsNode(std::shared_ptr<UsbFunction> function, Bytes descriptors, std::vector<std::string> texts);

  /// umockdev's handler of the node, to be attached there; it keeps the node alive.
  GObjectPointer<UMockdevIoctlBase> MakeHandler();
  /// The cable is pulled: every transfer ends, nothing begins.
  void Unplug();

 private:
  struct Transfer {
    GObjectPointer<UMockdevIoctlData> urb, buffer;  ///< buffer: none for a transfer of no bytes
  };
  struct Opening {
    std::deque<Transfer> pending, finished;
    bool claims = false;
  };
  struct Answer {
    long result = 0;
    int error = 0;
  };
  struct ParkedReap;

  static gboolean OnIoctl(UMockdevIoctlBase* handler, UMockdevIoctlClient* client, gpointer node) noexcept;
  static void OnConnected(UMockdevIoctlClient* client, GParamSpec* property, gpointer node) noexcept;
  static gboolean OnParkedReap(gpointer parked) noexcept;
  /// The signal calls with this node, which it keeps alive.
  void Connect(gpointer object, const char* signal, GCallback call);
  void Handle(UMockdevIoctlClient* client);
  Answer Request(UMockdevIoctlClient* client, Opening& opening);
  Answer Submit(UMockdevIoctlData* argument, Opening& opening);
  Answer Discard(UMockdevIoctlData* argument, Opening& opening);
  Answer Claim(Opening& opening);
  /// Carries out what can be, and hands over one that is finished: EAGAIN when there is none.
  Answer Reap(UMockdevIoctlData* argument, Opening& opening);
  void CarryOut(Opening& opening);
  /// Whether the transfer has come to its end.
  bool CarryOut(Transfer& transfer);
  std::optional<std::size_t> ControlTransfer(std::span<std::uint8_t> bytes);

  std::shared_ptr<UsbFunction> function_;
  Bytes descriptors_;
  std::vector<std::string> texts_;
  std::mutex mutex_;  ///< guards what follows
  bool plugged_in_ = true;
  std::map<UMockdevIoctlClient*, Opening> openings_;
};

}  // namespace rigcal::sim
