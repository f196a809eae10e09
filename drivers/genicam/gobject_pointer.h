#pragma once

#include <arv.h>

#include <memory>
#include <string>

namespace rigcal {

struct GObjectUnref {
  void operator()(gpointer object) const { g_object_unref(object); }
};

/// Holds one reference of a GObject.
template <typename T>
using GObjectPointer = std::unique_ptr<T, GObjectUnref>;

/// Takes the error of one call of a GLib library.
class GLibError {
 public:
  GLibError() = default;
  GLibError(const GLibError&) = delete;
  GLibError& operator=(const GLibError&) = delete;
  ~GLibError() { g_clear_error(&error_); }

  /// For the call's last argument; forgets the error of an earlier call.
  GError** Take() {
    g_clear_error(&error_);
    return &error_;
  }
  [[nodiscard]] bool Happened() const { return error_ != nullptr; }
  [[nodiscard]] std::string Text() const { return error_ != nullptr ? error_->message : "no reason is given"; }
  [[nodiscard]] bool IsDevice(ArvDeviceError code) const {
    return g_error_matches(error_, ARV_DEVICE_ERROR, code) != FALSE;
  }

 private:
  GError* error_ = nullptr;
};

}  // namespace rigcal
