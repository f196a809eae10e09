#include "sim_fixtures/u3v/usbfs_node.h"

#include <linux/usbdevice_fs.h>
#include <sys/ioctl.h>

#include <algorithm>
#include <cerrno>
#include <set>
#include <string>
#include <utility>

namespace rigcal::sim {
namespace {

/// A reap that finds nothing is answered after this time: libusb asks again at once, without end, while a transfer is
/// pending, because the node always looks ready to poll(2).
constexpr guint kPark_ms = 1;
constexpr std::uint8_t kInput = 0x80, kGetDescriptor = 6, kDeviceType = 1, kConfigurationType = 2, kTextType = 3;
constexpr std::size_t kSetup_bytes = 8, kDevice_bytes = 18;
constexpr std::uint32_t kCapabilities = USBDEVFS_CAP_ZERO_PACKET | USBDEVFS_CAP_BULK_CONTINUATION |
                                        USBDEVFS_CAP_NO_PACKET_SIZE_LIM | USBDEVFS_CAP_BULK_SCATTER_GATHER |
                                        USBDEVFS_CAP_REAP_AFTER_DISCONNECT;

usbdevfs_urb& UrbOf(UMockdevIoctlData* data) {
  return *reinterpret_cast<usbdevfs_urb*>(data->data);
}

/// The memory that an argument points to.
GObjectPointer<UMockdevIoctlData> Resolve(UMockdevIoctlData* data, std::size_t offset, std::size_t count) {
  return GObjectPointer<UMockdevIoctlData>(umockdev_ioctl_data_resolve(data, offset, count, nullptr));
}

/// A text as a string descriptor (UTF-16), index 0: the languages.
Bytes TextDescriptor(const std::vector<std::string>& texts, std::size_t index) {
  constexpr std::uint8_t kEnglishLow = 0x09, kEnglishHigh = 0x04;
  Bytes bytes = {2, kTextType};
  if (index == 0) bytes.insert(bytes.end(), {kEnglishLow, kEnglishHigh});
  if (index > 0 && index <= texts.size()) {
    for (const char letter : texts[index - 1]) bytes.insert(bytes.end(), {static_cast<std::uint8_t>(letter), 0});
  }
  bytes[0] = static_cast<std::uint8_t>(bytes.size());
  return bytes;
}

}  // namespace

struct UsbfsNode::ParkedReap {
  std::shared_ptr<UsbfsNode> node;
  GObjectPointer<UMockdevIoctlClient> client;
};

UsbfsNode::UsbfsNode(std::shared_ptr<UsbFunction> function, Bytes descriptors, std::vector<std::string> texts)
    : function_(std::move(function)), descriptors_(std::move(descriptors)), texts_(std::move(texts)) {}

void UsbfsNode::Connect(gpointer object, const char* signal, GCallback call) {
  const auto drop = [](gpointer node, GClosure*) { delete static_cast<std::shared_ptr<UsbfsNode>*>(node); };
  g_signal_connect_data(object, signal, call, new std::shared_ptr<UsbfsNode>(shared_from_this()), drop,
                        GConnectFlags{});
}

GObjectPointer<UMockdevIoctlBase> UsbfsNode::MakeHandler() {
  GObjectPointer<UMockdevIoctlBase> handler(umockdev_ioctl_base_new());
  Connect(handler.get(), "handle-ioctl", G_CALLBACK(OnIoctl));
  return handler;
}

void UsbfsNode::Unplug() {
  const std::lock_guard lock(mutex_);
  plugged_in_ = false;
}

gboolean UsbfsNode::OnIoctl(UMockdevIoctlBase* /*handler*/, UMockdevIoctlClient* client, gpointer node) noexcept {
  (*static_cast<std::shared_ptr<UsbfsNode>*>(node))->Handle(client);
  return TRUE;
}

void UsbfsNode::OnConnected(UMockdevIoctlClient* client, GParamSpec* /*property*/, gpointer node) noexcept {
  if (umockdev_ioctl_client_get_connected(client) != FALSE) return;
  UsbfsNode& self = **static_cast<std::shared_ptr<UsbfsNode>*>(node);
  const std::lock_guard lock(self.mutex_);
  self.openings_.erase(client);
}

void UsbfsNode::Handle(UMockdevIoctlClient* client) {
  Answer answer;
  {
    const std::lock_guard lock(mutex_);
    const auto [opening, first_seen] = openings_.try_emplace(client);
    if (first_seen) Connect(client, "notify::connected", G_CALLBACK(OnConnected));
    answer = Request(client, opening->second);
  }
  const bool reap = umockdev_ioctl_client_get_request(client) == USBDEVFS_REAPURBNDELAY;
  if (!reap || answer.error != EAGAIN) {
    umockdev_ioctl_client_complete(client, answer.result, answer.error);
    return;
  }
  GSource* later = g_timeout_source_new(kPark_ms);
  g_source_set_callback(later, OnParkedReap,
                        new ParkedReap{shared_from_this(), GObjectPointer<UMockdevIoctlClient>(
                                                               UMOCKDEV_IOCTL_CLIENT(g_object_ref(client)))},
                        [](gpointer parked) { delete static_cast<ParkedReap*>(parked); });
  g_source_attach(later, g_main_context_get_thread_default());
  g_source_unref(later);
}

gboolean UsbfsNode::OnParkedReap(gpointer parked) noexcept {
  const auto& [node, client] = *static_cast<ParkedReap*>(parked);
  Answer answer;
  {
    const std::lock_guard lock(node->mutex_);
    answer = node->Reap(umockdev_ioctl_client_get_arg(client.get()), node->openings_[client.get()]);
  }
  umockdev_ioctl_client_complete(client.get(), answer.result, answer.error);
  return G_SOURCE_REMOVE;
}

UsbfsNode::Answer UsbfsNode::Request(UMockdevIoctlClient* client, Opening& opening) {
  UMockdevIoctlData* argument = umockdev_ioctl_client_get_arg(client);
  const gulong request = umockdev_ioctl_client_get_request(client);
  if (request == USBDEVFS_REAPURBNDELAY) return Reap(argument, opening);
  if (!plugged_in_) return {-1, ENODEV};
  switch (request) {
    case USBDEVFS_GET_CAPABILITIES: {
      const auto capabilities = Resolve(argument, 0, sizeof(kCapabilities));
      std::memcpy(capabilities->data, &kCapabilities, sizeof(kCapabilities));
      return {};
    }
    case USBDEVFS_CLAIMINTERFACE:
    case USBDEVFS_DISCONNECT_CLAIM:
      return Claim(opening);
    case USBDEVFS_RELEASEINTERFACE:
      opening.claims = false;
      return {};
    case USBDEVFS_CLEAR_HALT:
    case USBDEVFS_SETINTERFACE:
    case USBDEVFS_SETCONFIGURATION:
    case USBDEVFS_RESET:
      return {};
    case USBDEVFS_GETDRIVER:
    case USBDEVFS_IOCTL:  // to take a driver of the kernel off: there is none
      return {-1, ENODATA};
    case USBDEVFS_SUBMITURB:
      return Submit(argument, opening);
    case USBDEVFS_DISCARDURB:
      return Discard(argument, opening);
    default:
      return {-1, ENOTTY};
  }
}

UsbfsNode::Answer UsbfsNode::Claim(Opening& opening) {
  const bool by_other = std::ranges::any_of(
      openings_, [&](const auto& other) { return &other.second != &opening && other.second.claims; });
  if (by_other || !function_->MayBeClaimed()) return {-1, EBUSY};
  opening.claims = true;
  return {};
}

UsbfsNode::Answer UsbfsNode::Submit(UMockdevIoctlData* argument, Opening& opening) {
  Transfer transfer{.urb = Resolve(argument, 0, sizeof(usbdevfs_urb))};
  if (!transfer.urb) return {-1, EFAULT};
  const int room_bytes = UrbOf(transfer.urb.get()).buffer_length;
  if (room_bytes > 0) {
    transfer.buffer = Resolve(transfer.urb.get(), offsetof(usbdevfs_urb, buffer), static_cast<std::size_t>(room_bytes));
    if (!transfer.buffer) return {-1, EFAULT};
  }
  opening.pending.push_back(std::move(transfer));
  return {};
}

UsbfsNode::Answer UsbfsNode::Discard(UMockdevIoctlData* argument, Opening& opening) {
  const auto address = GetLittle<gulong>({argument->data, sizeof(gulong)}, 0);
  const auto found = std::ranges::find_if(
      opening.pending, [&](const Transfer& transfer) { return transfer.urb->client_addr == address; });
  if (found == opening.pending.end()) return {-1, EINVAL};
  UrbOf(found->urb.get()).status = -ENOENT;
  UrbOf(found->urb.get()).actual_length = 0;
  opening.finished.push_back(std::move(*found));
  opening.pending.erase(found);
  return {};
}

UsbfsNode::Answer UsbfsNode::Reap(UMockdevIoctlData* argument, Opening& opening) {
  if (opening.finished.empty()) CarryOut(opening);
  if (opening.finished.empty()) return {-1, plugged_in_ ? EAGAIN : ENODEV};
  const Transfer transfer = std::move(opening.finished.front());
  opening.finished.pop_front();
  const auto pointer = Resolve(argument, 0, sizeof(void*));
  umockdev_ioctl_data_set_ptr(pointer.get(), 0, transfer.urb.get());
  return {};
}

void UsbfsNode::CarryOut(Opening& opening) {
  std::set<std::uint8_t> waiting;  // endpoints: a later transfer never passes an earlier one of the same
  for (auto transfer = opening.pending.begin(); transfer != opening.pending.end();) {
    const std::uint8_t endpoint = UrbOf(transfer->urb.get()).endpoint;
    if (waiting.contains(endpoint) || !CarryOut(*transfer)) {
      waiting.insert(endpoint);
      ++transfer;
      continue;
    }
    opening.finished.push_back(std::move(*transfer));
    transfer = opening.pending.erase(transfer);
  }
}

bool UsbfsNode::CarryOut(Transfer& transfer) {
  usbdevfs_urb& urb = UrbOf(transfer.urb.get());
  std::span<std::uint8_t> bytes;
  if (transfer.buffer) bytes = {transfer.buffer->data, static_cast<std::size_t>(urb.buffer_length)};
  urb.status = 0;
  urb.actual_length = urb.buffer_length;
  if (!plugged_in_) {
    urb.status = -ENODEV;
    urb.actual_length = 0;
  } else if (urb.type == USBDEVFS_URB_TYPE_CONTROL) {
    const std::optional<std::size_t> count = ControlTransfer(bytes);
    urb.status = count ? 0 : -EPIPE;
    urb.actual_length = static_cast<int>(count.value_or(0));
  } else if ((urb.endpoint & kInput) == 0) {
    function_->Take(urb.endpoint, bytes);
  } else {
    const std::optional<std::size_t> count = function_->Give(urb.endpoint, bytes);
    if (!count) return false;
    urb.actual_length = static_cast<int>(*count);
  }
  return true;
}

/// Requests without data that it knows not are taken; of those with data it knows the descriptors.
std::optional<std::size_t> UsbfsNode::ControlTransfer(std::span<std::uint8_t> bytes) {
  if (bytes.size() < kSetup_bytes) return std::nullopt;
  const std::uint8_t kind = bytes[0], request = bytes[1], index = bytes[2], type = bytes[3];
  if ((kind & kInput) == 0) return 0;
  if (request != kGetDescriptor) return std::nullopt;
  Bytes wanted;
  if (type == kTextType) wanted = TextDescriptor(texts_, index);
  const auto device_end =
      descriptors_.begin() + static_cast<std::ptrdiff_t>(std::min(kDevice_bytes, descriptors_.size()));
  if (type == kDeviceType) wanted = {descriptors_.begin(), device_end};
  if (type == kConfigurationType) wanted = {device_end, descriptors_.end()};
  const std::span<std::uint8_t> room = bytes.subspan(kSetup_bytes);
  const std::size_t count = std::min(room.size(), wanted.size());
  std::copy_n(wanted.begin(), count, room.begin());
  return count;
}

}  // namespace rigcal::sim
