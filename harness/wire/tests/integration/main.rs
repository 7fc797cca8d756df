//! The codecs against golden frames, third-party tools, captures and damaged data.

mod addresses;
mod alarm;
mod code_words;
mod frames_captures;
mod frames_etherparse;
mod frames_scapy;
mod frames_tshark;
mod http_peers;
mod parameter;
mod physical_captures;
mod profibus_manuals;
mod profibus_profirust;
mod profibus_pyprofibus;
mod profibus_robustness;
mod profibus_stream;
mod record_captures;
mod robustness;
mod round_trip;
mod rpc_captures;
mod rpc_reading;
mod rpc_scapy;
mod station_name;
