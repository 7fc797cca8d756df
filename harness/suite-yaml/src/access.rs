//! `read`, `write` and `send`: which service carries them, and what is changed against the right request.

use super::answer::{RequestKind, may_accept, only};
use super::device_yaml::{flag_value, named, plain};
use super::dialect::profinet::{
    INTERFACES, LOADS, OBJECTS, PACKETS, SNMP_REQUESTS, SNMP_VERSIONS, load, ping, record_read, rpc, snmp,
};
use super::dialect::{self, Dialect, Service as From};
use super::error::{Mistake, Read, every};
use super::frame::{StepScope, octets, text};
use super::keys::{Key, Keyed};
use super::names::{Name, Verbs};
use super::request_keys::{SOUGHT, record_request};
use super::yaml::Node;
use controllers::profinet_io::DamagedIoFrame;
use expression::{Program, Type};
use station::Duration;
use suite::device::{AnswerPart, NameKind};
use suite::model::{
    AccessChannel, AccessItem, AcyclicAccess, AcyclicService, AnswerMatcher, IdentifyTarget, IpFragments, Matcher,
    PingService, RecordPlace, RequestDeviation, RpcService, SnmpService, TimeSpan,
};
use wire::ethernet::Mac;
use wire::profidrive::ParameterFormat;
use wire::profinet::dcp::ResetMode;
use wire::profinet::rpc::Uuid;
use wire::snmp::{ObjectIdentifier, SnmpMessage, SnmpPduKind, SnmpVersion, VarBind};

/// Who acts, and whom it asks.
pub(super) struct RequestSender {
    /// Whether the second controller acts.
    pub second: bool,
    /// The addressed station where it is not the device (PROFIBUS).
    pub to: Option<Program>,
}

impl StepScope<'_, '_> {
    /// A `read` or a `write`: its items, and the service that all of them share.
    pub(super) fn access(
        &self,
        node: &Node,
        write: bool,
        instead: Option<&Node>,
        answer: Option<&Node>,
        by: RequestSender,
    ) -> Read<AcyclicAccess> {
        let (verb, word) = if write { (Verbs::WRITE, "write") } else { (Verbs::READ, "read") };
        let entries = node.entries(word)?;
        if entries.is_empty() {
            return Err(node.wrong(format!("an empty `{word}`")));
        }
        let read: Vec<Read<Name>> = entries.iter().map(|(key, _)| self.name(key, verb, word)).collect();
        if read.iter().any(Result::is_err) {
            let rest = |(name, (key, value)): (Read<Name>, &(Node, Node))| match name {
                Ok(name) if answer.is_none() => self.checked_item(key, value, &name, write).err(),
                Ok(_) => None,
                Err(mistake) => Some(mistake),
            };
            let wrong = Mistake::all(read.into_iter().zip(entries).filter_map(rest));
            return Err(wrong.unwrap_or_else(|| node.wrong(format!("this `{word}` cannot be read"))));
        }
        let mut via = None;
        let mut names = Vec::new();
        for ((key, _), name) in entries.iter().zip(every(read)?) {
            let of = via_of(&name);
            if via.is_some_and(|via| via != of) {
                return Err(key
                    .wrong(format!("one `{word}` asks one service: parameters, one record, or the station"))
                    .help("write a step of its own"));
            }
            via = Some(of);
            names.push(name);
        }
        let via = via.unwrap_or(AccessChannel::Parameters);
        if via == AccessChannel::Parameters && instead.is_none_or(|instead| instead.get("subslot").is_none()) {
            self.reaches_parameters(node)?;
        }
        let asked: Vec<(u16, u16)> = names.iter().filter_map(|name| parameter(&name.kind)).collect();
        let asked = match via {
            AccessChannel::Parameters => RequestKind::Parameters(&asked),
            AccessChannel::Record(_) => RequestKind::Whole(From::Record),
            AccessChannel::Diagnosis | AccessChannel::Configuration => RequestKind::Whole(From::Dp),
            AccessChannel::Station | AccessChannel::Stand | AccessChannel::Pages => RequestKind::Whole(From::Station),
        };
        let from = service_of(via);
        let answer = answer.map(|answer| self.answer(answer, asked)).transpose()?;
        let item = |(name, (key, value)): (Name, &(Node, Node))| {
            let value = &*self.bits_as_number(value, key, &name)?;
            let matcher = match write {
                true => super::matcher::written(self, value, &name.ty)?,
                false => self.matcher(value, &name.ty, Some(from))?,
            };
            self.exists(key, &name, write, &matcher, answer.as_ref())?;
            Ok(AccessItem { name: name.id, value: matcher })
        };
        let items = every(names.into_iter().zip(entries).map(item))?;
        let instead = instead.map_or(Ok(Vec::new()), |node| self.instead(node, via, write))?;
        let RequestSender { second, to } = by;
        Ok(AcyclicAccess { via, items, instead, answer, second, to })
    }

    /// An item of a `read` or `write` without an answer, by itself.
    fn checked_item(&self, key: &Node, value: &Node, name: &Name, write: bool) -> Read<()> {
        let value = &*self.bits_as_number(value, key, name)?;
        let matcher = match write {
            true => super::matcher::written(self, value, &name.ty)?,
            false => self.matcher(value, &name.ty, Some(service_of(via_of(name))))?,
        };
        self.exists(key, name, write, &matcher, None)
    }

    /// Whether parameters can be reached with the module in use: on PROFINET through one of its submodules, or one of the access point.
    fn reaches_parameters(&self, node: &Node) -> Read<()> {
        let device = self.names.device();
        if device.profinet().is_none() {
            return Ok(());
        }
        let points: Vec<usize> = device.parameter_points().collect();
        let Some(first) = points.first().and_then(|&point| device.submodules.get(point)) else {
            let mistake = node.wrong("parameters cannot be reached: no submodule of this device gives access to them");
            return Err(mistake.help("name the submodule in device.yaml: `parameter_access: { at: SUBMODULE }`"));
        };
        let Some(module) = self.progress.module.get().and_then(|module| device.modules.get(module)) else {
            return Ok(());
        };
        let is_there = |point: &usize| {
            module.submodules.contains(point) || device.submodules.get(*point).is_some_and(|point| point.slot == 0)
        };
        match points.iter().any(is_there) {
            true => Ok(()),
            false => Err(node
                .wrong(format!("parameters cannot be reached: the module `{}` has no access to them", module.name))
                .help(format!(
                    "connect with a module that has the submodule `{}`, or add it to this module",
                    first.name
                ))),
        }
    }

    /// A parameter that the device lacks may only be requested to be refused, and so may a write to a read-only one.
    fn exists(
        &self,
        key: &Node,
        name: &Name,
        write: bool,
        matcher: &Matcher,
        answer: Option<&AnswerMatcher>,
    ) -> Read<()> {
        let NameKind::Parameter { parameter, number, subindex, .. } = name.kind else {
            return Ok(());
        };
        let own = answer.map(|answer| match answer {
            AnswerMatcher::Parts(parts) => parts
                .iter()
                .find(|(part, _)| *part == AnswerPart::Parameter(number, subindex))
                .map(|(_, answer)| answer),
            answer => Some(answer),
        });
        let refusal = match (write, matcher, own.flatten()) {
            (false, Matcher::Refused(codes), _) | (true, _, Some(AnswerMatcher::Refused(codes))) => {
                Some(codes.as_slice())
            }
            _ => None,
        };
        let device = self.names.device();
        let Some(known) = parameter.and_then(|index| device.parameters.get(index)) else {
            return match refusal {
                Some(codes) if only(codes, &["unknown_parameter"]) => Ok(()),
                _ => {
                    let all: Vec<String> =
                        device.parameters.iter().map(|parameter| format!("P{}", parameter.number)).collect();
                    let mistake =
                        Mistake::unknown(key.spot, "parameter", &format!("P{number}"), all.iter().map(String::as_str));
                    Err(mistake.help("a parameter that the device lacks may only be `{ refused: unknown_parameter }`"))
                }
            };
        };
        let element = if known.elements.is_empty() {
            subindex == 0
        } else {
            subindex == 0 || known.elements.iter().any(|(_, index)| *index == subindex)
        };
        if !element && !refusal.is_some_and(|codes| only(codes, &["no_such_subindex", "no_array"])) {
            let names: Vec<&str> = known.elements.iter().map(|(name, _)| name.as_str()).collect();
            return Err(key.wrong(format!("P{number} has no element {subindex}")).help(match names.is_empty() {
                true => "it is no array; an element that does not exist may only be refused with `no_array` or `no_such_subindex`".to_owned(),
                false => format!("its elements are {}", names.join(", ")),
            }));
        }
        if write && !known.writable && own.flatten().is_none_or(may_accept) {
            return Err(key
                .wrong(format!("P{number} can only be read"))
                .help("say which answer is right: `answer: { refused: read_only }`"));
        }
        Ok(())
    }

    fn instead(&self, node: &Node, via: AccessChannel, write: bool) -> Read<Vec<RequestDeviation>> {
        let dialect = dialect::of(self.names.device().bus.kind());
        let set = match via {
            AccessChannel::Parameters => dialect.parameter_request,
            AccessChannel::Record(_) => &record_request::KEYS,
            AccessChannel::Pages => return Err(node.wrong("nothing is changed in the request for a web page")),
            AccessChannel::Diagnosis | AccessChannel::Configuration => {
                return Err(node.wrong("nothing is changed in the request for a diagnosis or a configuration"));
            }
            AccessChannel::Station | AccessChannel::Stand => match dialect.station_request {
                Some(set) => set,
                None => return Err(node.wrong("nothing is changed in this request")),
            },
        };
        Keyed::new(node, set)?;
        let mut list = Vec::new();
        for (key, value) in node.entries("instead")? {
            let name = key.text("a key")?;
            list.push(match name {
                "reference" => RequestDeviation::Reference(self.number(value, "a reference")?),
                "request" => RequestDeviation::Request(self.number(value, "a request")?),
                "do_id" => RequestDeviation::DoId(self.number(value, "a DO-ID")?),
                "count" => RequestDeviation::Count(self.number(value, "a number of parameters")?),
                "attribute" => RequestDeviation::Attribute(self.number(value, "an attribute")?),
                "elements" => RequestDeviation::Elements(self.number(value, "a number of elements")?),
                "subindex" => RequestDeviation::Subindex(self.number(value, "a subindex")?),
                "format" => RequestDeviation::Format(self.format(value)?),
                "values" => RequestDeviation::Values(self.number(value, "a number of values")?),
                "length" => RequestDeviation::Length(self.number(value, "a length")?),
                "bytes" => RequestDeviation::Bytes(octets(value)?),
                "slot" => RequestDeviation::Slot(self.number(value, "a slot")?),
                "subslot" => RequestDeviation::Subslot(self.number(value, "a subslot")?),
                "api" => RequestDeviation::Api(self.number(value, "an API")?),
                "index" => RequestDeviation::Index(self.number(value, "an index")?),
                "qualifier" => RequestDeviation::Qualifier(self.number(value, "a qualifier")?),
                "destination" if !write => {
                    let mistake = key.wrong("a read from another station has no answer to compare with");
                    return Err(mistake.help("write to it, with `answer: none`"));
                }
                "destination" => match <[u8; 6]>::try_from(octets(value)?) {
                    Ok(mac) => RequestDeviation::Destination(Mac(mac)),
                    Err(_) => return Err(value.wrong("a MAC address has 6 bytes")),
                },
                _ => RequestDeviation::StationValue(octets(value)?),
            });
        }
        if list.is_empty() { Err(node.wrong("an empty `instead`")) } else { Ok(list) }
    }

    fn format(&self, node: &Node) -> Read<u8> {
        match node.plain() {
            Some(text) if text.starts_with(|c: char| c.is_ascii_alphabetic()) => match ParameterFormat::by_word(text) {
                Some(format) => Ok(format.0),
                None => Err(Mistake::unknown(
                    node.spot,
                    "format",
                    text,
                    ParameterFormat::TABLE.iter().map(|(_, word, _)| *word),
                )),
            },
            _ => self.number(node, "a format"),
        }
    }

    /// The service of `send` and what its answer can consist of.
    pub(super) fn service(&self, node: &Node) -> Read<(AcyclicService, RequestKind<'static>)> {
        let entries = named(node, "send")?;
        let [(name, fields)] = entries.as_slice() else {
            return Err(node.wrong("one `send` sends one service"));
        };
        let bus = self.names.device().bus.kind();
        let services = dialect::of(bus).services;
        let Dialect { services: others, bus: other_bus, .. } = dialect::other_than(bus);
        let Some((set, _)) = services.iter().find(|(set, _)| set.name == *name) else {
            if others.iter().any(|(set, _)| set.name == *name) {
                return Err(node.wrong(format!("`{name}` exists on {other_bus} only")));
            }
            let spot = node.mapping().and_then(|entries| entries.first()).map_or(node.spot, |(key, _)| key.spot);
            return Err(Mistake::unknown(spot, "service", name, services.iter().map(|(set, _)| set.name)));
        };
        Keyed::new(fields, set)?;
        if self.names.device().profibus().is_some() {
            return self.dp_service(name, fields);
        }
        let field = |key: &str| fields.get(key).ok_or_else(|| fields.wrong(format!("{name} needs `{key}`")));
        let text = |key: &str| text(field(key)?);
        let service = match *name {
            "dcp_reset" => reset(field("mode")?)?,
            "dcp_signal" => AcyclicService::DcpSignal,
            "dcp_identify" => {
                AcyclicService::DcpIdentify(match (fields.get("who"), fields.get("name"), fields.get("alias")) {
                    (None, None, None) => self.filters(fields)?,
                    (Some(who), None, None) => IdentifyTarget::Who(SOUGHT.find(who, "who")?),
                    (None, Some(_), None) => IdentifyTarget::Name(text("name")?),
                    (None, None, Some(_)) => IdentifyTarget::Alias(text("alias")?),
                    _ => return Err(fields.wrong("dcp_identify needs one of `name`, `alias` and `who`")),
                })
            }
            "arp" | "arp_probe" => {
                let ip = fields.get("ip").map(|ip| self.value(ip, &Type::Address));
                AcyclicService::Arp { ip: ip.transpose()?, probe: *name == "arp_probe" }
            }
            "record_read" => AcyclicService::RecordRead {
                at: self.record_place(fields)?,
                length: self.number(field("length")?, "a length")?,
                implicit: flag_value(fields.get(record_read::implicit.name), &record_read::implicit)?,
            },
            "record_write" => {
                AcyclicService::RecordWrite { at: self.record_place(fields)?, bytes: octets(field("bytes")?)? }
            }
            "records_write" => AcyclicService::RecordsWrite(self.records(field("records")?)?),
            "dcp_get" => AcyclicService::DcpGet { elements: octets(field("elements")?)? },
            "dcp_set" => AcyclicService::DcpSet { blocks: octets(field("blocks")?)? },
            "rpc" => AcyclicService::Rpc(self.rpc(fields)?),
            "snmp" => AcyclicService::Snmp(self.snmp(fields)?),
            "load" => self.load(fields)?,
            "ping" => AcyclicService::Ping(self.ping(fields)?),
            "lldp" => AcyclicService::Lldp { chassis: text("chassis")?, port: text("port")? },
            "abort" => AcyclicService::Abort,
            "http_get" => AcyclicService::HttpGet { page: self.page(field("page")?)? },
            "http_post" => {
                let page = self.page(field("page")?)?;
                AcyclicService::HttpPost { page, fields: self.fields(page, field("fields")?)? }
            }
            _ => {
                let frame = field("frame")?;
                let word = plain(frame, "a frame")?;
                match DamagedIoFrame::by_word(word) {
                    Some(_) => AcyclicService::Broken(word.to_owned()),
                    None => {
                        let known: Vec<&str> = DamagedIoFrame::TABLE.iter().map(|(_, word, _)| *word).collect();
                        return Err(Mistake::unknown(frame.spot, "broken frame", word, known));
                    }
                }
            }
        };
        let asked = match service {
            AcyclicService::HttpGet { .. } | AcyclicService::HttpPost { .. } => RequestKind::Web,
            AcyclicService::RecordRead { .. }
            | AcyclicService::RecordWrite { .. }
            | AcyclicService::RecordsWrite(_)
            | AcyclicService::Rpc(_) => RequestKind::Whole(From::Record),
            AcyclicService::Broken(_) => RequestKind::Whole(From::Last),
            _ => RequestKind::Whole(From::Station),
        };
        Ok((service, asked))
    }
}

/// What carries the requests of a channel.
fn service_of(via: AccessChannel) -> From {
    match via {
        AccessChannel::Parameters => From::Parameters,
        AccessChannel::Record(_) => From::Record,
        AccessChannel::Diagnosis | AccessChannel::Configuration => From::Dp,
        AccessChannel::Station | AccessChannel::Stand | AccessChannel::Pages => From::Station,
    }
}

impl StepScope<'_, '_> {
    /// The place of a record that is accessed by its numbers.
    fn record_place(&self, fields: &Node) -> Read<RecordPlace> {
        let field = |key: &str| fields.get(key).ok_or_else(|| fields.wrong(format!("a record needs `{key}`")));
        Ok(RecordPlace {
            api: fields.get("api").map(|api| self.number(api, "an API")).transpose()?,
            slot: self.number(field("slot")?, "a slot")?,
            subslot: self.number(field("subslot")?, "a subslot")?,
            index: self.number(field("index")?, "an index")?,
        })
    }

    /// The records of a `records_write`.
    fn records(&self, node: &Node) -> Read<Vec<(RecordPlace, Vec<u8>)>> {
        let record = |fields: &Node| {
            let bytes = fields.get("bytes").ok_or_else(|| fields.wrong("a record needs `bytes`"))?;
            Ok((self.record_place(fields)?, octets(bytes)?))
        };
        node.items("records")?.iter().map(record).collect()
    }

    /// The filters of a DCP Identify as bytes.
    fn filters(&self, fields: &Node) -> Read<IdentifyTarget> {
        let Some(filters) = fields.get("filters") else {
            return Err(fields.wrong("dcp_identify needs one of `name`, `alias`, `who` and `filters`"));
        };
        let delay = fields.get("delay").map_or(Ok(1), |delay| self.number(delay, "a delay factor"))?;
        let wait = match fields.get("within").map(|within| self.span(within)).transpose()? {
            None => Duration::from_secs(1),
            Some(TimeSpan::Time(time)) => time,
            Some(_) => return Err(fields.key("within").wrong("this time is known beforehand")),
        };
        Ok(IdentifyTarget::Filters { octets: octets(filters)?, delay, wait })
    }

    /// The fields of an RPC PDU.
    fn rpc(&self, fields: &Node) -> Read<RpcService> {
        let word = |key: &Key| fields.get(key.name);
        let interface =
            word(&rpc::interface).map_or(Ok(Uuid::DEVICE_INTERFACE), |node| INTERFACES.read(node, &rpc::interface))?;
        let is_mapper = interface == Uuid::ENDPOINT_MAPPER;
        let (version, object) = if is_mapper { (3, Some(Uuid::NIL)) } else { (1, None) };
        let number =
            |key: &Key, default: u32| word(key).map_or(Ok(default), |node| self.number::<u32>(node, key.sentence));
        let body = word(&rpc::body).or(word(&rpc::blocks)).map_or(Ok(Vec::new()), octets)?;
        let opnum = word(&rpc::opnum).ok_or_else(|| fields.wrong("rpc needs `opnum`"))?;
        let sent = word(&rpc::sent)
            .map(|sent| sent.items("sent")?.iter().map(|item| self.number(item, "the number of a fragment")).collect());
        Ok(RpcService {
            packet: word(&rpc::packet).map_or(Ok(0), |node| PACKETS.read(node, &rpc::packet))?,
            interface: interface.0,
            interface_version: number(&rpc::interface_version, version)?,
            object: word(&rpc::object)
                .map_or(Ok(object), |node| OBJECTS.read(node, &rpc::object))?
                .map(|object| object.0),
            opnum: self.number(opnum, "an operation")?,
            same_activity: word(&rpc::activity).is_some(),
            sequence: number(&rpc::sequence, 0)?,
            server_boot: number(&rpc::server_boot, 0)?,
            little_endian: word(&rpc::byte_order).is_some(),
            body,
            is_whole_body: word(&rpc::blocks).is_none(),
            fragment: word(&rpc::fragment).map(|node| self.number(node, "a number of bytes")).transpose()?,
            sent: sent.transpose()?,
            ip_fragments: match word(&rpc::ip_fragment) {
                None => None,
                octets => Some(self.ip_fragments(octets, word(&rpc::ip_sent))?),
            },
        })
    }

    /// A net load.
    fn load(&self, fields: &Node) -> Read<AcyclicService> {
        let field = |key: &Key| fields.get(key.name).ok_or_else(|| fields.wrong(format!("load needs `{}`", key.name)));
        let gap = match fields.get(load::gap.name).map(|gap| self.span(gap)).transpose()? {
            None => Duration::from_millis(1),
            Some(TimeSpan::Time(time)) => time,
            Some(_) => return Err(fields.key("gap").wrong("this time is known beforehand")),
        };
        let kind = LOADS.read(field(&load::frames)?, &load::frames)?.to_owned();
        Ok(AcyclicService::Load { kind, count: self.number(field(&load::count)?, "a number of frames")?, gap })
    }

    /// An ICMP echo request.
    fn ping(&self, fields: &Node) -> Read<PingService> {
        let of = |key: &Key| fields.get(key.name);
        Ok(PingService {
            ip: of(&ping::ip).map(|ip| self.value(ip, &Type::Address)).transpose()?,
            length: of(&ping::length).map_or(Ok(32), |node| self.number(node, "a number of bytes"))?,
            is_damaged: flag_value(of(&ping::wrong_checksum), &ping::wrong_checksum)?,
            ip_fragments: self.ip_fragments(of(&ping::ip_fragment), of(&ping::ip_sent))?,
        })
    }

    /// How a packet is sent in IP fragments.
    fn ip_fragments(&self, octets: Option<&Node>, sent: Option<&Node>) -> Read<IpFragments> {
        let number = |item: &Node| self.number(item, "the number of a fragment");
        let sent = sent.map(|sent| sent.items("ip_sent")?.iter().map(number).collect());
        let octets = octets.map(|node| self.number::<usize>(node, "a number of bytes")).transpose()?;
        Ok(IpFragments { octets, sent: sent.transpose()? })
    }

    /// An SNMP message, or the bytes instead.
    fn snmp(&self, fields: &Node) -> Read<SnmpService> {
        let of = |key: &Key| fields.get(key.name);
        let Some(names) = of(&snmp::names) else {
            let bytes = of(&snmp::bytes).ok_or_else(|| fields.wrong("snmp needs `names` or `bytes`"))?;
            return Ok(SnmpService { octets: octets(bytes)?, is_message: false });
        };
        let number = |key: &Key| of(key).map_or(Ok(0), |node| self.number::<i32>(node, key.sentence));
        let (tag, value) = match of(&snmp::value).map(octets).transpose()?.as_deref() {
            None => (wire::snmp::NULL, Vec::new()),
            Some([tag, length, content @ ..]) if usize::from(*length) == content.len() => (*tag, content.to_vec()),
            Some(_) => {
                return Err(fields
                    .key("value")
                    .wrong("a value has a type, a length of one byte and a content that fits it"));
            }
        };
        let mut bindings = Vec::new();
        for name in text(names)?.split_whitespace() {
            let Some(name) = ObjectIdentifier::from_dotted(name) else {
                let wrong = names.wrong(format!("`{name}` is not the name of an object"));
                return Err(wrong.help("write numbers with dots between, for instance '1.3.6.1.2.1.1.1.0'"));
            };
            bindings.push(VarBind { name, tag, value: value.clone() });
        }
        let message = SnmpMessage {
            version: of(&snmp::version)
                .map_or(Ok(SnmpVersion::V2C), |node| SNMP_VERSIONS.read(node, &snmp::version))?,
            community: of(&snmp::community).map_or_else(|| Ok("public".to_owned()), text)?.into_bytes(),
            kind: of(&snmp::request).map_or(Ok(SnmpPduKind::GET), |node| SNMP_REQUESTS.read(node, &snmp::request))?,
            request_id: 0,
            error_status: number(&snmp::non_repeaters)?,
            error_index: number(&snmp::repetitions)?,
            bindings,
        };
        Ok(SnmpService { octets: message.to_vec(), is_message: true })
    }

    fn page(&self, node: &Node) -> Read<usize> {
        let name = plain(node, "a page")?;
        let pages = &self.names.device().pages;
        let Some(index) = pages.iter().position(|page| page.name == name) else {
            return Err(Mistake::unknown(node.spot, "page", name, pages.iter().map(|page| page.name.as_str())));
        };
        self.names.mark("page", name);
        Ok(index)
    }

    /// What is entered in the fields of a form.
    fn fields(&self, page: usize, node: &Node) -> Read<Vec<(usize, String)>> {
        let of = &self.names.device().pages[page];
        let mut entered = Vec::new();
        for (name, value) in named(node, "fields")? {
            let Some(index) = of.fields.iter().position(|(known, _)| known == name) else {
                let known = of.fields.iter().map(|(known, _)| known.as_str());
                return Err(Mistake::unknown(node.key(name).spot, "field of the page", name, known));
            };
            self.names.mark("page field", &format!("{}.{name}", of.name));
            entered.push((index, text(value)?));
        }
        Ok(entered)
    }
}

/// Words for what a reset by DCP resets; `factory` is the older service, which does not say.
fn reset(node: &Node) -> Read<AcyclicService> {
    let word = plain(node, "a mode")?;
    if word == "factory" {
        return Ok(AcyclicService::DcpReset { suboption: 5, qualifier: 0 });
    }
    match ResetMode::by_word(word) {
        Some(mode) => Ok(AcyclicService::DcpReset { suboption: 6, qualifier: mode.0 << 1 }),
        None => {
            let known: Vec<&str> = ResetMode::TABLE.iter().map(|(_, word, _)| *word).chain(["factory"]).collect();
            Err(Mistake::unknown(node.spot, "mode", word, known))
        }
    }
}

fn via_of(name: &Name) -> AccessChannel {
    match name.kind {
        NameKind::Record { record, .. } => AccessChannel::Record(record),
        NameKind::Station(_) => AccessChannel::Station,
        NameKind::Diagnosis(_) => AccessChannel::Diagnosis,
        NameKind::Configuration => AccessChannel::Configuration,
        NameKind::Parameter { .. } => AccessChannel::Parameters,
        NameKind::Page { .. } => AccessChannel::Pages,
        _ => AccessChannel::Stand,
    }
}

fn parameter(kind: &NameKind) -> Option<(u16, u16)> {
    match kind {
        NameKind::Parameter { number, subindex, .. } => Some((*number, *subindex)),
        _ => None,
    }
}
