// Writes a frame of each type that MicroSim speaks, packed by the C++ library OpenIGTLink, a line each: name, then the bytes in hexadecimal.
//
//   c++ -o frames frames.cxx -I/usr/include/openigtlink -lOpenIGTLink && ./frames > openigtlink-1.11.txt
//
// The values are those of `frames.rs`, which decodes and encodes them.

#include <cstdio>
#include <cstring>

#include "igtlCapabilityMessage.h"
#include "igtlPositionMessage.h"
#include "igtlQuaternionTrackingDataMessage.h"
#include "igtlStatusMessage.h"
#include "igtlStringMessage.h"
#include "igtlTimeStamp.h"
#include "igtlTrackingDataMessage.h"
#include "igtlTransformMessage.h"

// A turn by 90 degrees about z, then a translation.
static igtl::Matrix4x4 turned = {{0, -1, 0, 1.5f}, {1, 0, 0, -2.25f}, {0, 0, 1, 300}, {0, 0, 0, 1}};
static igtl::Matrix4x4 straight = {{1, 0, 0, -7}, {0, 1, 0, 8}, {0, 0, 1, 0.125f}, {0, 0, 0, 1}};

template <class Message>
static void print(const char* name, Message message, const char* device = "Forceps") {
  igtl::TimeStamp::Pointer time = igtl::TimeStamp::New();
  // 2026-01-02 03:04:05 UTC and three quarters of a second.
  time->SetTime(1767323045, static_cast<igtlUint32>(750000000));
  message->SetDeviceName(device);
  message->SetTimeStamp(time);
  message->Pack();
  std::printf("%s ", name);
  const unsigned char* bytes = static_cast<const unsigned char*>(message->GetPackPointer());
  for (int i = 0; i < message->GetPackSize(); i++) std::printf("%02x", bytes[i]);
  std::printf("\n");
  std::fflush(stdout);
}

int main() {
  igtl::TransformMessage::Pointer transform = igtl::TransformMessage::New();
  transform->SetMatrix(turned);
  print("TRANSFORM", transform);
  // A name of all 20 bytes, without a NUL.
  print("TRANSFORM-20", transform, "ABCDEFGHIJKLMNOPQRST");

  igtl::PositionMessage::Pointer position = igtl::PositionMessage::New();
  position->SetPosition(1.5f, -2.25f, 300);
  position->SetQuaternion(0, 0, 0.6f, 0.8f);
  // The shorter forms of 24 and 12 bytes are not here: the library writes behind its buffer when it packs them.
  print("POSITION", position);

  igtl::TrackingDataMessage::Pointer tools = igtl::TrackingDataMessage::New();
  igtl::TrackingDataElement::Pointer tool = igtl::TrackingDataElement::New();
  tool->SetName("left");
  tool->SetType(igtl::TrackingDataElement::TYPE_6D);
  tool->SetMatrix(turned);
  tools->AddTrackingDataElement(tool);
  tool = igtl::TrackingDataElement::New();
  tool->SetName("right");
  tool->SetType(igtl::TrackingDataElement::TYPE_5D);
  tool->SetMatrix(straight);
  tools->AddTrackingDataElement(tool);
  print("TDATA", tools);
  print("TDATA-0", igtl::TrackingDataMessage::New());

  igtl::QuaternionTrackingDataMessage::Pointer turns = igtl::QuaternionTrackingDataMessage::New();
  igtl::QuaternionTrackingDataElement::Pointer turn = igtl::QuaternionTrackingDataElement::New();
  turn->SetName("left");
  turn->SetType(igtl::QuaternionTrackingDataElement::TYPE_6D);
  turn->SetPosition(1.5f, -2.25f, 300);
  turn->SetQuaternion(0, 0, 0.6f, 0.8f);
  turns->AddQuaternionTrackingDataElement(turn);
  print("QTDATA", turns);

  igtl::StartTrackingDataMessage::Pointer start = igtl::StartTrackingDataMessage::New();
  start->SetResolution(20);
  start->SetCoordinateName("Field");
  print("STT_TDATA", start);
  igtl::StartQuaternionTrackingDataMessage::Pointer startTurns = igtl::StartQuaternionTrackingDataMessage::New();
  startTurns->SetResolution(20);
  startTurns->SetCoordinateName("Field");
  print("STT_QTDATA", startTurns);
  print("STP_TDATA", igtl::StopTrackingDataMessage::New());
  print("STP_QTDATA", igtl::StopQuaternionTrackingDataMessage::New());
  igtl::RTSTrackingDataMessage::Pointer reply = igtl::RTSTrackingDataMessage::New();
  reply->SetStatus(0);
  print("RTS_TDATA", reply);
  igtl::RTSQuaternionTrackingDataMessage::Pointer refused = igtl::RTSQuaternionTrackingDataMessage::New();
  refused->SetStatus(1);
  print("RTS_QTDATA", refused);
  print("GET_TRANS", igtl::GetTransformMessage::New());

  igtl::StringMessage::Pointer string = igtl::StringMessage::New();
  string->SetEncoding(106);
  string->SetString("Grün");
  print("STRING", string);

  igtl::StatusMessage::Pointer status = igtl::StatusMessage::New();
  status->SetCode(igtl::StatusMessage::STATUS_NOT_READY);
  status->SetSubCode(-3);
  status->SetErrorName("CAMERA");
  status->SetStatusString("warming up");
  print("STATUS", status);

  igtl::CapabilityMessage::Pointer capability = igtl::CapabilityMessage::New();
  capability->SetTypes({"TRANSFORM", "TDATA", "STT_TDATA"});
  print("CAPABILITY", capability);
  return 0;
}
