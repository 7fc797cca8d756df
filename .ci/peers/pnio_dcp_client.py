"""pnio-dcp, a DCP client of others, against the served XAC7718.

    python pnio_dcp_client.py CONTROL

Identify, to all and to one; name and address, read and written; names that the manual forbids; blink; both resets.
It sends frames of less than 60 octets.
"""

from pnio_dcp import DCP
from pnio_dcp.dcp_constants import ResetFactoryModes

from common import *


def described(device):
    return device.MAC, device.name_of_station, device.IP, device.netmask, device.gateway, device.family


def main():
    client = DCP(CONTROLLER_IP)
    there = (DEVICE_MAC, DEVICE_NAME, DEVICE_IP, NETMASK, GATEWAY, STATION_TYPE)
    check("identify all", [described(device) for device in client.identify_all(timeout=2)], [there])
    check("identify by a frame to the device alone", described(client.identify(DEVICE_MAC)), there)
    check("get name", client.get_name_of_station(DEVICE_MAC), DEVICE_NAME)
    check("get IP", client.get_ip_address(DEVICE_MAC), DEVICE_IP)

    check("set name for good", client.set_name_of_station(DEVICE_MAC, "hall-4.encoder").code, 0)
    check("get name: the new one", client.get_name_of_station(DEVICE_MAC), "hall-4.encoder")
    check("set name: one of 64 letters is refused", client.set_name_of_station(DEVICE_MAC, "a" * 64).code != 0, True)
    check("set name: one with a dash at its end is refused", client.set_name_of_station(DEVICE_MAC, "encoder-").code != 0, True)
    check("get name: still the new one", client.get_name_of_station(DEVICE_MAC), "hall-4.encoder")
    address = ["192.168.0.77", "255.255.255.0", "192.168.0.254"]
    check("set IP for good", client.set_ip_address(DEVICE_MAC, address).code, 0)
    device = client.identify(DEVICE_MAC)
    check("identify: the new name and address", (device.name_of_station, device.IP, device.netmask, device.gateway),
          ("hall-4.encoder", *address))
    check("set IP until power is lost", client.set_ip_address(DEVICE_MAC, ["192.168.0.78", NETMASK, GATEWAY], False).code, 0)
    check("get IP: the one until power is lost", client.get_ip_address(DEVICE_MAC), "192.168.0.78")
    check("set name until power is lost", client.set_name_of_station(DEVICE_MAC, "guest", False).code, 0)
    check("get name: the one until power is lost", client.get_name_of_station(DEVICE_MAC), "guest")
    check("stand: power off and on", (stand("power down"), stand("power up")), ("ok", "ok"))
    time.sleep(3)
    device = client.identify(DEVICE_MAC)
    check("after power came back: neither name nor address, for the last ones were until power is lost",
          (device.name_of_station, device.IP), ("", "0.0.0.0"))
    check("set name for good again", client.set_name_of_station(DEVICE_MAC, "hall-4.encoder").code, 0)
    check("stand: power off and on again", (stand("power down"), stand("power up")), ("ok", "ok"))
    time.sleep(3)
    check("after power came back: the name for good", client.get_name_of_station(DEVICE_MAC), "hall-4.encoder")

    check("blink", client.blink(DEVICE_MAC).code, 0)
    check("set IP again", client.set_ip_address(DEVICE_MAC, address).code, 0)
    check("reset of the communication", client.reset_to_factory(DEVICE_MAC, ResetFactoryModes.RESET_COMMUNICATION).code, 0)
    device = client.identify(DEVICE_MAC)
    check("after it: neither name nor address", (device.name_of_station, device.IP), ("", "0.0.0.0"))
    check("set name again", client.set_name_of_station(DEVICE_MAC, DEVICE_NAME).code, 0)
    check("factory reset", client.factory_reset(DEVICE_MAC).code, 0)
    check("after it: no name", client.get_name_of_station(DEVICE_MAC), "")
    finish()


main()
