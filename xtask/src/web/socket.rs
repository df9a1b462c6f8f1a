//! A WebSocket to a program on this machine (RFC 6455), for text only.

use std::io::{self, BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::time::Duration;

/// An open connection.
pub(super) struct Socket {
    stream: BufReader<TcpStream>,
}

/// Maximum length of a received message [bytes].
const MOST_BYTES: u64 = 1 << 28;

impl Socket {
    /// Connects to `ws://HOST:PORT/PATH`.
    pub(super) fn open(url: &str) -> io::Result<Self> {
        let bad = |what: &str| io::Error::other(format!("{url}: {what}"));
        let rest = url.strip_prefix("ws://").ok_or_else(|| bad("not a WebSocket"))?;
        let (host, path) = rest.split_once('/').ok_or_else(|| bad("no path"))?;
        let stream = TcpStream::connect(host)?;
        stream.set_nodelay(true)?;
        let mut stream = BufReader::new(stream);
        // The key protects against caches, and there are none here.
        write!(
            stream.get_mut(),
            "GET /{path} HTTP/1.1\r\nHost: {host}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n\
             Sec-WebSocket-Key: ZHJ5c3RvbmUgZHJ5c3Rvbg==\r\nSec-WebSocket-Version: 13\r\n\r\n"
        )?;
        let mut line = String::new();
        stream.read_line(&mut line)?;
        if !line.contains(" 101 ") {
            return Err(bad(line.trim()));
        }
        while line.trim() != "" {
            line.clear();
            stream.read_line(&mut line)?;
        }
        Ok(Self { stream })
    }

    pub(super) fn send(&mut self, text: &str) -> io::Result<()> {
        self.send_frame(TEXT, text.as_bytes())
    }

    fn send_frame(&mut self, kind: u8, bytes: &[u8]) -> io::Result<()> {
        // A complete frame, masked as a client's frames must be; a zero mask leaves the bytes
        // unchanged.
        let mut frame = vec![0x80 | kind];
        match (u8::try_from(bytes.len()), u16::try_from(bytes.len())) {
            (Ok(length @ 0..126), _) => frame.push(0x80 | length),
            (_, Ok(length)) => {
                frame.push(0x80 | 126);
                frame.extend(length.to_be_bytes());
            }
            _ => {
                frame.push(0x80 | 127);
                frame.extend((bytes.len() as u64).to_be_bytes());
            }
        }
        frame.extend([0; 4]);
        frame.extend(bytes);
        self.stream.get_mut().write_all(&frame)
    }

    /// The next text from the other side, if it arrives within this time.
    pub(super) fn receive(&mut self, within: Duration) -> io::Result<String> {
        // A timeout of zero would be refused.
        let within = within.max(Duration::from_millis(1));
        self.stream.get_ref().set_read_timeout(Some(within))?;
        let mut text = Vec::new();
        loop {
            let [first, second] = self.bytes()?;
            let length = match second & 0x7F {
                126 => u64::from(u16::from_be_bytes(self.bytes()?)),
                127 => u64::from_be_bytes(self.bytes()?),
                short => u64::from(short),
            };
            if length > MOST_BYTES {
                return Err(io::Error::other("a message is too long"));
            }
            let begin = text.len();
            (&mut self.stream).take(length).read_to_end(&mut text)?;
            match first & 0x0F {
                CLOSE => return Err(io::Error::other("the other side closed the connection")),
                PING => {
                    let ping = text.split_off(begin);
                    self.send_frame(PONG, &ping)?;
                }
                PONG => text.truncate(begin),
                // The last frame of a message.
                _ if first & 0x80 != 0 => {
                    return String::from_utf8(text).map_err(io::Error::other);
                }
                _ => {}
            }
        }
    }

    fn bytes<const N: usize>(&mut self) -> io::Result<[u8; N]> {
        let mut bytes = [0; N];
        self.stream.read_exact(&mut bytes)?;
        Ok(bytes)
    }
}

const TEXT: u8 = 1;
const CLOSE: u8 = 8;
const PING: u8 = 9;
const PONG: u8 = 10;

#[cfg(test)]
mod tests {
    use std::io::{Read, Write};
    use std::net::TcpListener;
    use std::time::Duration;

    use super::Socket;

    #[test]
    fn messages_in_parts_between_pings_arrive_whole() {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let url = format!("ws://{}/x", listener.local_addr().unwrap());
        let other = std::thread::spawn(move || {
            let (mut stream, _) = listener.accept().unwrap();
            let mut request = Vec::new();
            while !request.ends_with(b"\r\n\r\n") {
                let mut byte = [0];
                stream.read_exact(&mut byte).unwrap();
                request.extend(byte);
            }
            assert!(request.starts_with(b"GET /x HTTP/1.1\r\n"));
            stream.write_all(b"HTTP/1.1 101 Switching Protocols\r\nA: b\r\n\r\n").unwrap();
            stream.write_all(&[0x01, 2, b'a', b'b', 0x89, 1, b'!', 0x80, 1, b'c']).unwrap();
            let mut long = vec![0x81, 126, 0x01, 0x00];
            long.extend([b'z'; 256]);
            stream.write_all(&long).unwrap();
            let mut pong = [0; 7];
            stream.read_exact(&mut pong).unwrap();
            assert_eq!(pong, [0x8A, 0x81, 0, 0, 0, 0, b'!']);
            let mut sent = [0; 8];
            stream.read_exact(&mut sent).unwrap();
            assert_eq!(sent, [0x81, 0xFE, 0, 200, 0, 0, 0, 0]);
        });
        let mut socket = Socket::open(&url).unwrap();
        assert_eq!(socket.receive(Duration::from_secs(10)).unwrap(), "abc");
        assert_eq!(socket.receive(Duration::from_secs(10)).unwrap(), "z".repeat(256));
        socket.send(&"y".repeat(200)).unwrap();
        other.join().unwrap();
        assert!(Socket::open("http://x").is_err());
    }
}
