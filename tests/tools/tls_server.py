"""A server of https that should not be trusted, or does not speak it.

    tls_server.py PORT_FILE LOG MODE [CERTIFICATE KEY]    ends with its standard input

MODE: certified (a handshake with CERTIFICATE), garbage (bytes that are no handshake), plain (http), shut (closes at once), silent
(never answers), cut (closes in the middle of its answer to the handshake). LOG gets all that arrives readable, one connection a line.
"""
import os
import socket
import ssl
import sys
import threading

port_file, log_file, mode = sys.argv[1:4]
listener = socket.create_server(("127.0.0.1", 0))
context = None
if len(sys.argv) > 4:
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.load_cert_chain(sys.argv[4], sys.argv[5])


def serve(connection):
    told = b""
    try:
        if mode == "certified":
            connection = context.wrap_socket(connection, server_side=True)
            told = connection.recv(65536)
            connection.sendall(b"HTTP/1.1 200 OK\r\nContent-Length: 2\r\nContent-Type: application/json\r\n\r\n{}")
        elif mode != "shut":
            told = connection.recv(65536)
            if mode == "garbage":
                connection.sendall(os.urandom(4096))
            elif mode == "plain":
                connection.sendall(b"HTTP/1.1 200 OK\r\nContent-Length: 2\r\n\r\n{}")
            elif mode == "cut":
                connection.sendall(b"\x16\x03\x03\x40\x00\x02")
            elif mode == "silent":
                connection.recv(1)
    except OSError as error:
        told += str(error).encode()
    with open(log_file, "ab") as log:
        log.write(told.replace(b"\n", b" ") + b"\n")
    connection.close()


def accept():
    while True:
        threading.Thread(target=serve, args=(listener.accept()[0],), daemon=True).start()


threading.Thread(target=accept, daemon=True).start()
with open(port_file + ".new", "w") as file:
    file.write(str(listener.getsockname()[1]))
os.rename(port_file + ".new", port_file)
sys.stdin.read()
