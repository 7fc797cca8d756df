-- PROFIBUS for Wireshark: FDL frames and the services of DP, one frame in each packet, from its start delimiter to its end delimiter.
--
-- Wireshark refuses link type 257 (PROFIBUS_DL). `encspec replay CAPTURE --annotate OUT --user-link-type N` writes a capture with the user
-- link type N instead. Start with `wireshark -X lua_script:FILE OUT`, or put this file into the folder of personal Lua plugins.

local profibus = Proto("profibus", "PROFIBUS DP")
local known, words, bits = {}, {}, {}

local function add_field(name, field)
    known[name] = field
end

local function values(name, list)
    words[name] = {}
    for _, entry in ipairs(list or {}) do words[name][entry[1]] = entry[2] end
    return list and words[name]
end

local function decimal(name, title, list)
    add_field(name, ProtoField.uint32("profibus." .. name, title, base.DEC, values(name, list)))
end

local function hexadecimal(name, title, list)
    add_field(name, ProtoField.uint32("profibus." .. name, title, base.HEX, values(name, list)))
end

local function flags(name, title, list)
    hexadecimal(name, title)
    bits[name] = list
    for _, entry in ipairs(list) do
        local bit_name = name .. "." .. entry[2]
        add_field(bit_name, ProtoField.bool("profibus." .. bit_name, entry[2], base.NONE, nil, 0, entry[3]))
    end
end

local function octets(name, title)
    add_field(name, ProtoField.bytes("profibus." .. name, title))
end

local function text(name, title)
    add_field(name, ProtoField.string("profibus." .. name, title))
end

-- FIELDS

profibus.fields = (function()
    local all = {}
    for _, field in pairs(known) do all[#all + 1] = field end
    return all
end)()

local damaged_frame = ProtoExpert.new("profibus.damaged_frame", "The frame is damaged", expert.group.MALFORMED, expert.severity.ERROR)
profibus.experts = { damaged_frame }

-- The frame that is dissected, its fields so far, and the request before it.
local frame, found, asked = nil, {}, nil
-- The service of each frame that was dissected once.
local services = {}

function profibus.init()
    services, asked = {}, nil
end

-- Raised where the bytes of a frame end too early or contradict each other.
local DAMAGED = { "damaged" }

local function has(value, bit)
    return math.floor(value / bit) % 2 == 1
end

local function put(name, at, count, value)
    found[#found + 1] = { name = name, at = at, count = count, value = value }
end

local function take(part, count)
    local at = part.at
    if at + count > part.to then error(DAMAGED, 0) end
    part.at = at + count
    return at
end

local function left(part)
    return part.to - part.at
end

-- Reads a number without showing it.
local function peek_number(part, count)
    local at = take(part, count)
    return frame(at, count):uint(), at
end

local function number(part, name, count)
    local value, at = peek_number(part, count)
    put(name, at, count, value)
    return value
end

local function bytes(part, name, count)
    local at = take(part, count)
    if count > 0 then put(name, at, count) end
end

local function rest(part, name)
    bytes(part, name, left(part))
end

local function bit_field(part, name)
    local value, at = peek_number(part, 1)
    put(name, at, 1, value)
    for _, entry in ipairs(bits[name]) do put(name .. "." .. entry[2], at, 1, has(value, entry[1])) end
    return value
end

local function finish(part)
    if left(part) > 0 then error(DAMAGED, 0) end
end

local function blocks(part)
    while left(part) > 0 do
        local length = peek_number(part, 1)
        if length < 4 then error(DAMAGED, 0) end
        local at = take(part, length - 1)
        local block = { at = at, to = part.at }
        local kind = number(block, "block.type", 1)
        number(block, "block.slot", 1)
        take(block, 1)
        if words["block.type"][kind] == "isochronous" and left(block) == 24 then
            take(block, 1)
            number(block, "iso.t_base_dp", 4)
            number(block, "iso.t_dp", 2)
            number(block, "iso.t_mapc", 1)
            number(block, "iso.t_base_io", 4)
            number(block, "iso.t_i", 2)
            number(block, "iso.t_o", 2)
            number(block, "iso.t_dx", 4)
            number(block, "iso.t_pll_w", 2)
            number(block, "iso.t_pll_d", 2)
        else
            rest(block, "block.data")
        end
    end
end

local function set_prm(part)
    local begin = part.at
    local status = bit_field(part, "prm.status")
    local one = number(part, "prm.watchdog_factor_1", 1)
    local two = number(part, "prm.watchdog_factor_2", 1)
    number(part, "prm.min_tsdr", 1)
    number(part, "prm.ident", 2)
    number(part, "prm.groups", 1)
    local dpv1 = left(part) >= 3 and has(frame(part.at, 1):uint(), 0x80)
    local unit = dpv1 and has(frame(part.at, 1):uint(), 0x04) and 1 or 10
    if has(status, 0x08) then put("prm.watchdog", begin + 1, 2, one * two * unit) end
    if dpv1 then
        bit_field(part, "prm.dpv1_status_1")
        bit_field(part, "prm.dpv1_status_2")
        local third = bit_field(part, "prm.dpv1_status_3")
        put("prm.alarm_mode", part.at - 1, 1, third % 8)
        if has(third, 0x08) then return blocks(part) end
    end
    rest(part, "prm.user")
end

local function configuration(part)
    local outputs, inputs = 0, 0
    local begin = part.at
    local function length(value, limit)
        return (value % limit + 1) * (has(value, 0x40) and 2 or 1)
    end
    local function output(at, count)
        put("cfg.outputs", at, 1, count)
        outputs = outputs + count
    end
    local function input(at, count)
        put("cfg.inputs", at, 1, count)
        inputs = inputs + count
    end
    while left(part) > 0 do
        local head, at = peek_number(part, 1)
        if has(head, 0x20) or has(head, 0x10) then
            if has(head, 0x20) then output(at, length(head, 16)) end
            if has(head, 0x10) then input(at, length(head, 16)) end
        else
            local value
            if has(head, 0x80) then
                value, at = peek_number(part, 1)
                output(at, length(value, 64))
            end
            if has(head, 0x40) then
                value, at = peek_number(part, 1)
                input(at, length(value, 64))
            end
            if head % 16 ~= 15 then bytes(part, "cfg.manufacturer", head % 16) end
        end
    end
    put("cfg.all_outputs", begin, part.to - begin, outputs)
    put("cfg.all_inputs", begin, part.to - begin, inputs)
end

local function message(from, count)
    if count < 3 then return end
    local kind = frame(from, 1):uint()
    local name = has(kind, 0x80) and "diag.status_type" or "diag.alarm"
    if words[name][kind] == nil then return end
    put(name, from, 1, kind)
    put("diag.slot", from + 1, 1, frame(from + 1, 1):uint())
    put("diag.specifier", from + 2, 1, frame(from + 2, 1):uint())
end

local function slave_diag(part)
    bit_field(part, "diag.status_1")
    bit_field(part, "diag.status_2")
    bit_field(part, "diag.status_3")
    number(part, "diag.master", 1)
    number(part, "diag.ident", 2)
    while left(part) > 0 do
        local head, at = peek_number(part, 1)
        local kind, low = math.floor(head / 64), head % 64
        if kind == 2 then
            put("diag.channel.identifier", at, 1, low)
            local channel, of_channel = peek_number(part, 1)
            put("diag.channel.direction", of_channel, 1, math.floor(channel / 64))
            put("diag.channel.number", of_channel, 1, channel % 64)
            local fault, of_fault = peek_number(part, 1)
            put("diag.channel.type", of_fault, 1, math.floor(fault / 32))
            put("diag.channel.error", of_fault, 1, fault % 32)
        elseif kind == 3 then
            put("diag.revision", at, 1, low)
        else
            if low == 0 then error(DAMAGED, 0) end
            local from = take(part, low - 1)
            if kind == 0 then
                if low > 1 then put("diag.device", from, low - 1) end
                message(from, low - 1)
            else
                for bit = 0, (low - 1) * 8 - 1 do
                    local byte = from + math.floor(bit / 8)
                    if has(frame(byte, 1):uint(), 2 ^ (bit % 8)) then put("diag.identifier", byte, 1, bit) end
                end
            end
        end
    end
end

local function global_control(part)
    bit_field(part, "control.command")
    number(part, "control.groups", 1)
    finish(part)
end

local function set_slave_address(part)
    number(part, "address.new", 1)
    number(part, "address.ident", 2)
    number(part, "address.no_change", 1)
    rest(part, "address.data")
end

local function initiate(part)
    bytes(part, "dpv1.features", 2)
    bytes(part, "dpv1.profile_features", 2)
    number(part, "dpv1.profile", 2)
    take(part, 1)
    local source = peek_number(part, 1)
    take(part, 1)
    local destination = peek_number(part, 1)
    bytes(part, "dpv1.source", source)
    bytes(part, "dpv1.destination", destination)
end

local function acyclic(part, is_request)
    local code = number(part, "dpv1.function", 1)
    local word = words["dpv1.function"][code]
    if word == "data_transport" or word == "read" or word == "write" then
        number(part, "dpv1.slot", 1)
        number(part, "dpv1.index", 1)
        local length = number(part, "dpv1.length", 1)
        if word == "data_transport" or (word == "write") == is_request then bytes(part, "dpv1.record", length) end
    elseif word == "resource_manager" then
        number(part, "dpv1.sap", 1)
        number(part, "dpv1.send_timeout", 2)
    elseif word == "initiate" and is_request then
        take(part, 3)
        number(part, "dpv1.send_timeout", 2)
        initiate(part)
    elseif word == "initiate" then
        number(part, "dpv1.most_data", 1)
        initiate(part)
    elseif word == "abort" then
        number(part, "dpv1.subnet", 1)
        number(part, "dpv1.reason", 1)
        rest(part, "dpv1.more")
    elseif word == "alarm_ack" then
        number(part, "dpv1.slot", 1)
        number(part, "dpv1.alarm_type", 1)
        number(part, "dpv1.specifier", 1)
    elseif has(code, 0x80) then
        number(part, "dpv1.error_decode", 1)
        number(part, "dpv1.error_code_1", 1)
        number(part, "dpv1.error_code_2", 1)
    else
        rest(part, "dpv1.more")
    end
    finish(part)
end

local ACYCLIC = { resource_manager = true, alarm = true, server = true }
local OF_REQUESTS = {
    set_prm = set_prm,
    set_ext_prm = blocks,
    chk_cfg = configuration,
    global_control = global_control,
    set_slave_address = set_slave_address,
}
local OF_ANSWERS = { get_cfg = configuration, slave_diag = slave_diag }

local function carried(service, part, is_request)
    if left(part) == 0 then return end
    local of = (is_request and OF_REQUESTS or OF_ANSWERS)[service]
    if of then
        of(part)
    elseif ACYCLIC[service] or service:find("^ms2 by SAP") then
        acyclic(part, is_request)
    else
        rest(part, "data")
    end
end

-- Functions of the data link itself, and those that are not answered.
local LINK = { time_event = true, fdl_status = true, ident = true, lsap_status = true, clock_value = true }
local UNANSWERED = { time_event = true, clock_value = true, sdn_low = true, sdn_high = true }

local function service_of(is_request, function_word, slave, master, length)
    if not slave and not master then
        if is_request and LINK[function_word] then return function_word, true end
        if not is_request and length == 0 then return "answer" end
        return "data_exchange"
    end
    if not slave then return "data_exchange" end
    if master == 54 then return "master_master" end
    if master == 50 and slave < 49 then return "ms2 by SAP " .. slave end
    return SLAVE_SAPS[slave] or ("SAP " .. slave)
end

local function extension(part, name)
    local first = peek_number(part, 1)
    local at = part.at - 1
    if not has(first, 0x40) then
        if has(first, 0x80) then error(DAMAGED, 0) end
        put(name .. ".sap", at, 1, first % 64)
        return first % 64
    end
    put(name .. ".segment", at, 1, first % 64)
    if not has(first, 0x80) then return nil end
    local second = peek_number(part, 1)
    if second >= 64 then error(DAMAGED, 0) end
    put(name .. ".sap", at + 1, 1, second)
    return second
end

-- Dissects a frame with a function code whose addresses begin at `from`; `length` bytes are counted by its checksum.
local function data_frame(packet, from, length)
    local all = frame:len()
    if from + length + 2 ~= all then error(DAMAGED, 0) end
    local sum = 0
    for at = from, from + length - 1 do sum = (sum + frame(at, 1):uint()) % 256 end
    if frame(all - 2, 1):uint() ~= sum or frame(all - 1, 1):uint() ~= 0x16 then error(DAMAGED, 0) end
    local part = { at = from, to = from + length }
    local to, by, code = peek_number(part, 1), peek_number(part, 1), number(part, "fc", 1)
    local da, sa = to % 128, by % 128
    put("da", from, 1, da)
    put("sa", from + 1, 1, sa)
    local is_request = has(code, 0x40)
    local coded = code % 16 + (has(code, 0x80) and 128 or 0)
    local function_word
    if is_request then
        put("request", from + 2, 1, coded)
        put("count", from + 2, 1, (has(code, 0x10) and 2 or 0) + (has(code, 0x20) and 1 or 0))
        function_word = words.request[coded]
    else
        put("answer", from + 2, 1, coded)
        put("station", from + 2, 1, math.floor(code / 16) % 4)
        function_word = words.answer[coded]
    end
    local destination = to >= 128 and extension(part, "da") or nil
    local source = by >= 128 and extension(part, "sa") or nil
    put("fcs", all - 2, 1, sum)
    local slave, master = source, destination
    if is_request then slave, master = destination, source end
    local service, is_link = service_of(is_request, function_word, slave, master, left(part))
    if packet.visited then
        service = services[packet.number] or service
    else
        if is_request then
            asked = nil
            if function_word and not UNANSWERED[function_word] then
                asked = { da = da, sa = sa, service = service, is_link = is_link }
            end
        elseif asked then
            local fits = asked.da == sa and asked.sa == da
            if fits and (service == "answer" or service == "data_exchange" and asked.is_link) then service = asked.service end
            asked = nil
        end
        services[packet.number] = service
    end
    put("service", from, length, service)
    packet.cols.info = string.format("%d -> %d %s %s (%s)", sa, da, service, is_request and "request" or "answer",
        function_word or string.format("0x%02x", coded))
    local before, begin = #found, part.at
    local fine, problem = pcall(carried, service, part, is_request)
    if fine then return end
    if problem ~= DAMAGED then error(problem, 0) end
    for at = #found, before + 1, -1 do found[at] = nil end
    put("damaged", begin, from + length - begin, 1)
    put("data", begin, from + length - begin)
end

local function whole_frame(packet)
    local length = frame:len()
    if length == 0 then error(DAMAGED, 0) end
    local start = frame(0, 1):uint()
    put("start", 0, 1, start)
    local word = words.start[start]
    if word == "no_data" then
        data_frame(packet, 1, 3)
    elseif word == "eight_octets" then
        data_frame(packet, 1, 11)
    elseif word == "variable_data" then
        local part = { at = 1, to = length }
        local counted = number(part, "length", 1)
        local again, start_again = peek_number(part, 1), peek_number(part, 1)
        if counted < 4 or counted > 249 or again ~= counted or start_again ~= start then error(DAMAGED, 0) end
        data_frame(packet, 4, counted)
    elseif word == "token" and length == 3 then
        put("da", 1, 1, frame(1, 1):uint())
        put("sa", 2, 1, frame(2, 1):uint())
        put("service", 0, 3, "token")
        packet.cols.info = string.format("%d -> %d token", frame(2, 1):uint(), frame(1, 1):uint())
    elseif word == "short_acknowledgement" and length == 1 then
        if not packet.visited then
            services[packet.number] = asked and asked.service
            asked = nil
        end
        local service = services[packet.number]
        if service then put("service", 0, 1, service) end
        packet.cols.info = (service or "") .. " short acknowledgement"
    else
        error(DAMAGED, 0)
    end
end

function profibus.dissector(buffer, packet, tree)
    frame, found = buffer, {}
    packet.cols.protocol = "PROFIBUS"
    local fine, problem = pcall(whole_frame, packet)
    if not fine then
        if problem ~= DAMAGED then error(problem, 0) end
        found = {}
        put("damaged", 0, buffer:len(), 1)
        if buffer:len() > 0 then put("data", 0, buffer:len()) end
        packet.cols.info = "damaged"
    end
    local branch = tree:add(profibus, buffer())
    for _, item in ipairs(found) do
        local range = buffer(item.at, item.count)
        if item.name == "damaged" then
            branch:add(known[item.name], range, item.value):add_proto_expert_info(damaged_frame)
        elseif item.value == nil then
            branch:add(known[item.name], range)
        else
            branch:add(known[item.name], range, item.value)
        end
    end
    return buffer:len()
end

DissectorTable.get("wtap_encap"):add(wtap.USER0 + USER_LINK_TYPE, profibus)
