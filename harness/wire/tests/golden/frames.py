"""Builds frames with scapy and prints them as lines `name hex`; the golden bytes of tests/integration/frames_scapy.rs.

    pip install scapy==2.8.0
    python3 frames.py > scapy-rt-dcp.txt
"""

from scapy.contrib.lldp import (
    LLDPDUChassisID, LLDPDUEndOfLLDPDU, LLDPDUGenericOrganisationSpecific, LLDPDUPortID, LLDPDUPortDescription,
    LLDPDUSystemCapabilities, LLDPDUSystemDescription, LLDPDUSystemName, LLDPDUTimeToLive,
)
from scapy.contrib.pnio import PNIORealTimeCyclicPDU, PNIORealTime_IOxS, ProfinetIO
from scapy.contrib.pnio_dcp import (
    DCPAliasNameBlock, DCPBaseBlock, DCPControlBlock, DCPDeviceIDBlock, DCPDeviceInitiativeBlock,
    DCPDeviceInstanceBlock, DCPDeviceOptionsBlock, DCPDeviceRoleBlock, DCPFullIPBlock, DCPIPBlock, DCPMACBlock,
    DCPManufacturerSpecificBlock, DCPNameOfStationBlock, DCPOEMIDBlock, DeviceOption, ProfinetDCP,
)
from scapy.all import ARP, Dot1AD, Dot1Q, Ether, ICMP, IP, IPOption_NOP, Raw, UDP

CONTROLLER, DEVICE = "02:00:00:00:00:01", "02:00:00:00:01:00"
CONTROLLER_IP, DEVICE_IP = "192.168.0.1", "192.168.0.10"
IDENTIFY, HELLO = "01:0e:cf:00:00:00", "01:0e:cf:00:00:01"

print("# Frames built with scapy 2.8.0; made by: python3 frames.py > scapy-rt-dcp.txt")
print("# One frame per line: its name, then its bytes from the destination address on.")


def show(name, frame):
    print(name, bytes(frame).hex())


def padded(frame):
    return Raw(bytes(frame).ljust(60, b"\0"))


def to_device(frame_id, **tag):
    head = Ether(dst=DEVICE, src=CONTROLLER)
    if tag:
        head = head / Dot1Q(**tag)
        head.payload.type = 0x8892
    else:
        head.type = 0x8892
    return head / ProfinetIO(frameID=frame_id)


def to_controller(frame_id):
    return Ether(dst=CONTROLLER, src=DEVICE, type=0x8892) / ProfinetIO(frameID=frame_id)


# Cyclic frames: IOPS of the DAP, data with IOPS, an IOCS; padded to 40 bytes of data.
def cyclic(data, length=40, **status):
    inner = [Raw(data), PNIORealTime_IOxS(dataState=1), PNIORealTime_IOxS(dataState=0, instance=2)]
    padding = bytes(length - len(data) - 2)
    return PNIORealTimeCyclicPDU(data=inner, padding=padding, **status)


show("rt_untagged", to_device(0xC001) / cyclic(b"\x80\x04\x1f\x00\x00", cycleCounter=0x1240, dataStatus=0x35))
show("rt_tagged", to_device(0x8000, prio=6, vlan=0) / cyclic(b"\x80\x12\x34", cycleCounter=0xFFC0, dataStatus=0x15))
show("rt_long", to_device(0xC002) / cyclic(bytes(range(256)) * 5 + bytes(range(140)), 1440, cycleCounter=64,
                                            dataStatus=0xC8, transferStatus=1))
show("rt_two_tags", Ether(dst=DEVICE, src=CONTROLLER) / Dot1AD(prio=1, vlan=7) / Dot1Q(prio=6, vlan=0x123, type=0x8892)
     / ProfinetIO(frameID=0xC001) / cyclic(b"\x01", cycleCounter=1, dataStatus=0x34))


# DCP requests. scapy supports one block in a request and leaves its lengths to the caller.
def request(service, option, sub_option, block, **fields):
    return ProfinetDCP(service_id=service, service_type=0, xid=0x01000001, option=option, sub_option=sub_option,
                       dcp_block_length=block, dcp_data_length=4 + block + block % 2, **fields)


def identify(*args, **fields):
    return Ether(dst=IDENTIFY, src=CONTROLLER, type=0x8892) / ProfinetIO(frameID=0xFEFE) / request(5, *args, **fields)


show("identify_all", identify(255, 255, 0, reserved=1))
show("identify_by_name", identify(2, 2, 7, name_of_station=b"enc-one", reserved=6400))
show("identify_by_alias", identify(2, 6, 14, alias_name=b"port-001.enc-1", reserved=1))
show("get_device_id", to_device(0xFEFD) / ProfinetDCP(service_id=3, service_type=0, xid=0x01000001, option=2, sub_option=3,
                                                 dcp_data_length=2))
show("set_name_permanent", to_device(0xFEFD) / request(4, 2, 2, 9, block_qualifier=1, name_of_station=b"enc-one"))
show("set_name_temporary", to_device(0xFEFD) / request(4, 2, 2, 8, block_qualifier=0, name_of_station=b"enc-10"))
show("set_ip_permanent", to_device(0xFEFD) / request(4, 1, 2, 14, block_qualifier=1, ip=DEVICE_IP,
                                                     netmask="255.255.255.0", gateway=CONTROLLER_IP))
show("set_full_ip", to_device(0xFEFD) / request(4, 1, 3, 30, block_qualifier=0, ip=DEVICE_IP, netmask="255.255.255.0",
                                                gateway=CONTROLLER_IP, dnsaddr=["8.8.8.8", "9.9.9.9", "0.0.0.0", "1.1.1.1"]))
show("signal", padded(to_device(0xFEFD) / Raw(bytes(request(4, 5, 3, 4, block_qualifier=0))[:16] + b"\x01\x00")))
show("factory_reset", to_device(0xFEFD) / request(4, 5, 5, 2, block_qualifier=0))
show("reset_communication", to_device(0xFEFD) / request(4, 5, 6, 2, block_qualifier=4))
show("reset_all", to_device(0xFEFD) / request(4, 5, 6, 2, block_qualifier=8))


# DCP responses. scapy appends a byte to every block unless `padding` is empty.
EVEN, ODD = {"padding": b""}, {"padding": b"\0"}


def response(service, blocks, kind=1):
    frame_id = 0xFEFF if service == 5 else 0xFEFD
    return to_controller(frame_id) / ProfinetDCP(service_id=service, service_type=kind, xid=0x01000001,
                                                 dcp_data_length=sum(map(len, map(bytes, blocks))), dcp_blocks=blocks)


show("identify_response", response(5, [
    DCPManufacturerSpecificBlock(dcp_block_length=9, device_vendor_value=b"encoder", **ODD),
    DCPNameOfStationBlock(**EVEN, name_of_station=b"enc-10"),
    DCPDeviceIDBlock(**EVEN, dcp_block_length=6, vendor_id=0x0106, device_id=0x0303),
    DCPDeviceRoleBlock(**EVEN, device_role_details=1),
    DCPDeviceOptionsBlock(**EVEN, dcp_block_length=8, device_options=[
        DeviceOption(option=2, sub_option=2), DeviceOption(option=1, sub_option=2), DeviceOption(option=5, sub_option=6)]),
    DCPAliasNameBlock(alias_name=b"port-001.enc-1", **EVEN),
    DCPDeviceInstanceBlock(**EVEN, device_instance_high=0, device_instance_low=1),
    DCPOEMIDBlock(**EVEN, dcp_block_length=6, vendor_id=0x1234, device_id=0x5678),
    DCPMACBlock(**EVEN, dcp_block_length=8, mac=DEVICE),
    DCPIPBlock(**EVEN, dcp_block_length=14, block_info=0x81, ip=DEVICE_IP, netmask="255.255.255.0", gateway="0.0.0.0"),
    DCPFullIPBlock(**EVEN, dcp_block_length=30, block_info=2, ip=DEVICE_IP, netmask="255.255.0.0", gateway=CONTROLLER_IP,
                   dnsaddr=["8.8.8.8", "9.9.9.9", "0.0.0.0", "1.1.1.1"]),
    DCPDeviceInitiativeBlock(dcp_block_length=4, device_initiative=1),
    DCPBaseBlock(option=0x80, sub_option=9, dcp_block_length=6, data=b"\xde\xad\xbe\xef"),
]))
show("get_response", response(3, [DCPDeviceIDBlock(**EVEN, dcp_block_length=6, vendor_id=0x0106, device_id=0x0303),
                                  DCPControlBlock(response=3, response_sub_option=61, block_error=2, **ODD)]))
show("set_response_ok", response(4, [DCPControlBlock(response=2, response_sub_option=2, block_error=0, **ODD)]))
show("set_response_refused", response(4, [
    DCPControlBlock(response=1, response_sub_option=2, block_error=6, **ODD),
    DCPControlBlock(response=5, response_sub_option=2, block_error=1, **ODD)]))
show("not_supported", response(4, [], kind=5))

# ARP and UDP.
show("arp_request", padded(Ether(dst="ff:ff:ff:ff:ff:ff", src=CONTROLLER)
                           / ARP(op=1, hwsrc=CONTROLLER, psrc=CONTROLLER_IP, hwdst="00:00:00:00:00:00", pdst=DEVICE_IP)))
show("arp_reply", padded(Ether(dst=CONTROLLER, src=DEVICE)
                         / ARP(op=2, hwsrc=DEVICE, psrc=DEVICE_IP, hwdst=CONTROLLER, pdst=CONTROLLER_IP)))


def internet(**fields):
    return Ether(dst=DEVICE, src=CONTROLLER) / IP(src=CONTROLLER_IP, dst=DEVICE_IP, **fields)


UDP_PORTS = dict(sport=49152, dport=34964)
show("udp", internet(id=0, flags="DF") / UDP(**UDP_PORTS) / Raw(b"a datagram that needs no padding"))
show("udp_odd", internet(id=0, flags="DF") / UDP(**UDP_PORTS) / Raw(b"an odd number of octets in it"))
show("udp_short", padded(internet(id=0, flags="DF") / UDP(**UDP_PORTS) / Raw(b"short")))
show("udp_no_checksum", internet(id=9) / UDP(chksum=0, **UDP_PORTS) / Raw(b"nobody computed a sum"))
show("udp_bad_checksum", internet(id=9) / UDP(chksum=0x1234, **UDP_PORTS) / Raw(b"this sum is wrong"))
show("ip_bad_checksum", internet(id=9, chksum=0x1234) / UDP(**UDP_PORTS) / Raw(b"that sum is wrong"))
show("udp_options", internet(id=9, options=[IPOption_NOP()] * 4) / UDP(**UDP_PORTS) / Raw(b"behind options"))
show("udp_tagged", Ether(dst=DEVICE, src=CONTROLLER) / Dot1Q(prio=3, vlan=5)
     / IP(src=CONTROLLER_IP, dst=DEVICE_IP) / UDP(**UDP_PORTS) / Raw(b"behind a tag"))
show("ip_first_fragment", internet(id=7, flags="MF") / UDP(len=100, chksum=0, **UDP_PORTS) / Raw(bytes(16)))
show("ip_last_fragment", internet(id=7, frag=3, proto=17) / Raw(bytes(24)))
show("icmp", internet() / ICMP())

# LLDP.
PNO, IEEE = 0x000ECF, 0x00120F
show("lldp", Ether(dst="01:80:c2:00:00:0e", src=DEVICE, type=0x88CC)
     / LLDPDUChassisID(subtype=7, id=b"encoder-under-test") / LLDPDUPortID(subtype=7, id=b"port-001")
     / LLDPDUTimeToLive(ttl=20) / LLDPDUPortDescription(description=b"first port")
     / LLDPDUSystemName(system_name=b"encoder") / LLDPDUSystemDescription(description=b"an absolute encoder")
     / LLDPDUSystemCapabilities(station_only_available=1, station_only_enabled=1)
     / LLDPDUGenericOrganisationSpecific(org_code=PNO, subtype=1, data=bytes.fromhex("0000000100000002000000030000000400000005"))
     / LLDPDUGenericOrganisationSpecific(org_code=PNO, subtype=2, data=bytes.fromhex("00010002"))
     / LLDPDUGenericOrganisationSpecific(org_code=PNO, subtype=5, data=bytes.fromhex("020000000100"))
     / LLDPDUGenericOrganisationSpecific(org_code=IEEE, subtype=1, data=bytes.fromhex("036c000010"))
     / LLDPDUGenericOrganisationSpecific(org_code=0x0080C2, subtype=1, data=bytes.fromhex("0001"))
     / LLDPDUEndOfLLDPDU())
