"""Builds PROFIBUS frames with pyprofibus and prints them as lines `name hex`; the golden bytes of
tests/integration/profibus_pyprofibus.rs.

    pip install pyprofibus==1.13
    python3 profibus.py > pyprofibus.txt
"""

from pyprofibus.dp import (
    DpCfgDataElement, DpTelegram, DpTelegram_ChkCfg_Req, DpTelegram_DataExchange_Con, DpTelegram_DataExchange_Req,
    DpTelegram_GetCfg_Con, DpTelegram_GetCfg_Req, DpTelegram_GlobalControl, DpTelegram_SetPrm_Req, DpTelegram_SlaveDiag_Con,
    DpTelegram_SlaveDiag_Req,
)
from pyprofibus.fdl import (
    FdlFCB, FdlTelegram, FdlTelegram_ack, FdlTelegram_FdlStat_Con, FdlTelegram_FdlStat_Req, FdlTelegram_Ident_Req,
    FdlTelegram_Lsap_Req, FdlTelegram_stat0, FdlTelegram_token, FdlTelegram_var, FdlTransceiver,
)

MASTER, SLAVE = 2, 8

print("# Frames built with pyprofibus 1.13; made by: python3 profibus.py > pyprofibus.txt")
print("# One frame per line: its name, then its bytes from the start delimiter on.")


class PrintingPort:
    """A port for pyprofibus that prints the frames instead of sending them."""

    def __init__(self, name):
        self.name = name

    def send(self, telegram, srd):
        print(self.name, bytes(telegram.getRawData()).hex())


def show(name, telegram, fcb=None):
    if isinstance(telegram, DpTelegram):
        telegram = telegram.toFdlTelegram()
    if fcb is None:
        PrintingPort(name).send(telegram, False)
    else:
        FdlTransceiver(PrintingPort(name)).send(fcb, telegram)


# Only the data link.
show("token", FdlTelegram_token(da=MASTER, sa=126))
show("short_acknowledgement", FdlTelegram_ack())
show("fdl_status_request", FdlTelegram_FdlStat_Req(da=SLAVE, sa=MASTER))
show("fdl_status_answer", FdlTelegram_FdlStat_Con(da=MASTER, sa=SLAVE))
show("ident_request", FdlTelegram_Ident_Req(da=SLAVE, sa=MASTER))
show("lsap_request", FdlTelegram_Lsap_Req(da=SLAVE, sa=MASTER))
for name, code in (("user_error", FdlTelegram.FC_UE), ("no_resource", FdlTelegram.FC_RR), ("no_service", FdlTelegram.FC_RS),
                   ("no_data", FdlTelegram.FC_NR)):
    show("answer_" + name, FdlTelegram_stat0(da=MASTER, sa=SLAVE, fc=code))
show("answer_master_in_ring", FdlTelegram_stat0(da=MASTER, sa=3, fc=FdlTelegram.FC_OK | FdlTelegram.FC_MTR))
show("segments", FdlTelegram_var(da=SLAVE, sa=MASTER, fc=FdlTelegram.FC_REQ | FdlTelegram.FC_SRD_LO,
                                 dae=bytes([0x80 | 0x40 | 5, 60]), sae=bytes([0x40 | 63]), du=b""))

# The start of a slave, counted by the frame count bit.
fcb = FdlFCB(enable=True)
show("slave_diag_request_first", DpTelegram_SlaveDiag_Req(da=SLAVE, sa=MASTER), fcb)
fcb.handleReply()

prm = DpTelegram_SetPrm_Req(da=SLAVE, sa=MASTER)
prm.stationStatus |= DpTelegram_SetPrm_Req.STA_WD | DpTelegram_SetPrm_Req.STA_SYNC | DpTelegram_SetPrm_Req.STA_FREEZE
prm.wdFact1, prm.wdFact2, prm.minTSDR = 20, 5, 11
prm.identNumber, prm.groupIdent = 0x1655, 0x81
show("set_prm_plain", prm, fcb)
fcb.handleReply()

prm.addUserPrmData(bytes((
    DpTelegram_SetPrm_Req.DPV1PRM0_V1MODE | DpTelegram_SetPrm_Req.DPV1PRM0_FAILSAFE | DpTelegram_SetPrm_Req.DPV1PRM0_WD1MS,
    DpTelegram_SetPrm_Req.DPV1PRM1_ALRMDIAG | DpTelegram_SetPrm_Req.DPV1PRM1_ALRMPLUG | DpTelegram_SetPrm_Req.DPV1PRM1_REDCFG,
    DpTelegram_SetPrm_Req.DPV1PRM2_ALRMCNT12 | DpTelegram_SetPrm_Req.DPV1PRM2_ISO | DpTelegram_SetPrm_Req.DPV1PRM2_PRMBLK,
)) + bytes.fromhex("1c04000001000005dc000801000005dc00010002000002ee000c0000"))
show("set_prm_dpv1", prm, fcb)
fcb.handleReply()

cfg = DpTelegram_ChkCfg_Req(da=SLAVE, sa=MASTER)
cfg.addCfgDataElement(DpCfgDataElement(DpCfgDataElement.ID_CON_WHOLE | DpCfgDataElement.ID_LEN_WORDS
                                       | DpCfgDataElement.ID_TYPE_IN | 3))
cfg.addCfgDataElement(DpCfgDataElement(DpCfgDataElement.ID_TYPE_OUT | 1))
cfg.addCfgDataElement(DpCfgDataElement(DpCfgDataElement.ID_TYPE_INOUT | DpCfgDataElement.ID_LEN_WORDS | 15))
cfg.addCfgDataElement(DpCfgDataElement(DpCfgDataElement.ID_SPEC_INOUT | 3, bytes((
    DpCfgDataElement.LEN_CON_WHOLE | DpCfgDataElement.LEN_WORDS | 1,
    DpCfgDataElement.LEN_CON_WHOLE | DpCfgDataElement.LEN_WORDS | 5)) + bytes.fromhex("fd0051")))
cfg.addCfgDataElement(DpCfgDataElement(DpCfgDataElement.ID_SPEC_IN, bytes((63,))))
cfg.addCfgDataElement(DpCfgDataElement(DpCfgDataElement.ID_SPEC_OUT, bytes((DpCfgDataElement.LEN_WORDS | 7,))))
cfg.addCfgDataElement(DpCfgDataElement(DpCfgDataElement.ID_SPEC_FREE))
show("chk_cfg", cfg, fcb)
fcb.handleReply()

# Responses and Data_Exchange.
diag = DpTelegram_SlaveDiag_Con(da=MASTER, sa=SLAVE)
diag.b0 = DpTelegram_SlaveDiag_Con.B0_STANORDY | DpTelegram_SlaveDiag_Con.B0_PRMFLT
diag.b1 = DpTelegram_SlaveDiag_Con.B1_ONE | DpTelegram_SlaveDiag_Con.B1_WD | DpTelegram_SlaveDiag_Con.B1_PRMREQ
diag.b2, diag.masterAddr, diag.identNumber = DpTelegram_SlaveDiag_Con.B2_EXTDIAGOVR, 255, 0x1655
show("slave_diag_answer", diag)
show("get_cfg_request", DpTelegram_GetCfg_Req(da=SLAVE, sa=MASTER))
show("get_cfg_answer_empty", DpTelegram_GetCfg_Con(da=MASTER, sa=SLAVE))
show("data_exchange_request", DpTelegram_DataExchange_Req(da=SLAVE, sa=MASTER, du=bytes.fromhex("80001000")), fcb)
show("data_exchange_answer", DpTelegram_DataExchange_Con(da=MASTER, sa=SLAVE, du=bytes.fromhex("00055000")))
show("data_exchange_answer_high", DpTelegram_DataExchange_Con(da=MASTER, sa=SLAVE, fc=FdlTelegram.FC_DH, du=bytes(8)))
show("data_exchange_request_empty", DpTelegram_DataExchange_Req(da=SLAVE, sa=MASTER))
show("data_exchange_longest", DpTelegram_DataExchange_Req(da=SLAVE, sa=MASTER, du=bytes(range(244))))

control = DpTelegram_GlobalControl(da=127, sa=MASTER)
control.controlCommand = DpTelegram_GlobalControl.CCMD_SYNC | DpTelegram_GlobalControl.CCMD_FREEZE
control.groupSelect = DpTelegram_GlobalControl.GSEL_GROUP1 | DpTelegram_GlobalControl.GSEL_GROUP8
show("global_control", control)
clear = DpTelegram_GlobalControl(da=127, sa=MASTER)
clear.controlCommand = DpTelegram_GlobalControl.CCMD_CLEAR
show("global_control_clear", clear)

# Access points for which pyprofibus has numbers but no messages.
def request(name, dsap, ssap, data):
    show(name, FdlTelegram_var(da=SLAVE, sa=MASTER, fc=FdlTelegram.FC_REQ | FdlTelegram.FC_SRD_LO, dae=bytes([dsap]),
                               sae=bytes([ssap]), du=bytes.fromhex(data)))


request("set_slave_address", DpTelegram.DSAP_SET_SLAVE_ADR, DpTelegram.SSAP_MS0, "05165500")
request("set_ext_prm", DpTelegram.DSAP_EXT_USER_PRM, DpTelegram.SSAP_MS0, "0681000001ff")
request("rd_inp", DpTelegram.DSAP_RD_INP, DpTelegram.SSAP_MS0, "")
request("rd_outp", DpTelegram.DSAP_RD_OUTP, DpTelegram.SSAP_MS0, "")
request("ms1_read", DpTelegram.DSAP_SERVER, DpTelegram.SSAP_MS1, "5e002ff0")
request("ms1_alarm_ack", DpTelegram.DSAP_ALARM, DpTelegram.SSAP_MS1, "5c010108")
request("ms2_initiate", DpTelegram.DSAP_RESOURCE_MAN, DpTelegram.SSAP_MS2, "570000000064010000000303000200020000" "0000")
