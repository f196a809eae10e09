#include "daemon/api/api_reply.h"

#include <algorithm>
#include <array>

namespace rigcal {
namespace {

using Json = nlohmann::ordered_json;

struct CodeRow {
  ErrorCode code;
  const char* name;
  int status;
};
constexpr std::array<CodeRow, 9> kCodes = {{{ErrorCode::kBadInput, "bad_input", kStatusBadRequest},
                                            {ErrorCode::kNotFound, "not_found", kStatusNotFound},
                                            {ErrorCode::kIo, "io", kStatusInternal},
                                            {ErrorCode::kDiskFull, "disk_full", kStatusDiskFull},
                                            {ErrorCode::kUnsupported, "unsupported", kStatusBadRequest},
                                            {ErrorCode::kCancelled, "cancelled", kStatusUnavailable},
                                            {ErrorCode::kTimeout, "timeout", kStatusUnavailable},
                                            {ErrorCode::kDevice, "device", kStatusUnavailable},
                                            {ErrorCode::kConflict, "conflict", kStatusConflict}}};

const CodeRow& RowOf(ErrorCode code) {
  return *std::ranges::find(kCodes, code, &CodeRow::code);
}

}  // namespace

ApiReply ErrorReply(const Error& error) {
  const CodeRow& row = RowOf(error.code);
  return ErrorReply(row.status, row.name, error.message);
}

ApiReply ErrorReply(int status, const std::string& code, const std::string& message) {
  return {.status = status, .body = ReplyText({{"error", {{"code", code}, {"message", message}}}}), .events = {}};
}

std::string ReplyText(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

const char* NameOf(ErrorCode code) {
  return RowOf(code).name;
}

ErrorCode ErrorCodeFromName(const std::string& name) {
  const auto found = std::ranges::find_if(kCodes, [&](const CodeRow& row) { return row.name == name; });
  return found == kCodes.end() ? ErrorCode::kIo : found->code;
}

}  // namespace rigcal
