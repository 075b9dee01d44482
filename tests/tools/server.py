#!/usr/bin/env python3
"""A local model server for the tests: chat completions and the Open Inference Protocol, behaving or misbehaving.

server.py PORT_FILE LOG_FILE [PART:]MODE   serves on a free port of 127.0.0.1, which it writes to PORT_FILE; every request is a
line of JSON in LOG_FILE. With PART, only POST requests whose path has it see the misbehaviour. It ends when its standard input is closed, or after a minute.
"""

import base64
import http.server
import json
import os
import socket
import struct
import sys
import threading
import time

LABELS = [
    "Wood",
    "Metal",
    "Plastic",
    "Glass",
    "Fabric",
    "Leather",
    "Ceramic",
    "Stone",
    "Rubber",
    "Paper",
    "Sand",
    "Snow",
    "Plasticine",
    "Foam",
]
OUTPUTS = ["E_mean", "E_uncertainty", "nu_mean", "nu_uncertainty", "label_evidence"]

port_file, log_file, mode = sys.argv[1:4]
only, _, mode = mode.rpartition(":")
count = posts = 0
loaded_at = None
lock = threading.Lock()


def text_of(body):
    """The question; instructions may stand in front of it."""
    content = [m["content"] for m in body["messages"] if m["role"] == "user"][0]
    text = content if isinstance(content, str) else content[0]["text"]
    starts = [text.index(s) for s in ("The row: ", "The scene: ", "The views: ", "The question: ") if s in text]
    return text[min(starts) :] if starts else text


def material_answer(body):
    """What the material agent says of a row: the plate abstains, everything else is mostly foam."""
    text = text_of(body)
    key = json.loads(text[text.index("{") : text.index("}") + 1])["key"]
    answer = {
        "key": key,
        "abstain": False,
        "confidence": 0.8,
        "visible_views": ["front", "right", "top"],
        "labels": [{"label": "Foam", "probability": 0.75}, {"label": "Plasticine", "probability": 0.25}],
        "profiles": [{"profile": "Foam", "probability": 1.0}],
        "statistics": {"E": None, "nu": None},
    }
    if key.endswith("/plate"):
        answer.update(abstain=True, confidence=0, visible_views=[], labels=[], profiles=[])
    return answer


def scene_answer():
    """The scene agent's answer to the schema query about the toy of tests/cli/toy.bash."""
    row = {"object": "toy", "structural_role": "", "physics_group": "", "expected_labels": ["Wood"]}
    answer = {
        "objects": [{"id": "toy", "name": "toy", "scene_role": "subject"}],
        "rows": [{**row, "part": "ball", "name": "ball"}, {**row, "part": "box", "name": "box"}],
        "actions": [
            {
                "type": "translation",
                "source": None,
                "target": "the ball",
                "role": "target",
                "direction": "to the left",
                "magnitude": 100,
                "start": 0,
                "end": None,
            }
        ],
    }
    if mode == "unknown-row":
        answer["rows"].append({**row, "part": "wheel", "name": "wheel"})
    if mode == "twice":
        answer["rows"].append(dict(answer["rows"][0]))
    if mode == "no-action":
        answer["actions"][0]["type"] = "explode"
    if mode == "nowhere":
        answer["actions"][0]["target"] = "piano"
    if mode == "bad-direction":
        answer["actions"][0]["direction"] = "somewhere"
    return answer


def perception_answer(text):
    """Queries for the keys that are asked about; in mode miss, the ball is called by another name at first."""
    start = text.index("The keys: ") + len("The keys: ")
    things = json.JSONDecoder().raw_decode(text[start:])[0]
    names = {"toy": "toy", "toy/ball": "globe" if mode == "miss" else "ball", "toy/box": "box"}
    colors = {"toy": [], "toy/ball": [[230, 26, 26]], "toy/box": [[26, 26, 230]]}
    return {
        "queries": [
            {
                "key": t["key"],
                "text": "ball" if t["missed"] else names[t["key"]],
                "visible_views": ["front", "right", "back", "left"],
                "colors": colors[t["key"]],
            }
            for t in things
        ]
    }


def answer_to(body):
    text = text_of(body)
    if text.startswith("The question: "):  # of `pm-ground check`
        blind = mode == "blind"
        return {"color": "blue" if "sky" in text else "green" if "grass" in text else "none" if blind else "red"}
    if text.startswith("The scene: "):
        return scene_answer()
    if text.startswith("The views: "):
        return perception_answer(text)
    return material_answer(body)


def chat_reply(content):
    return {
        "id": "x",
        "object": "chat.completion",
        "choices": [{"index": 0, "finish_reason": "stop", "message": {"role": "assistant", "content": content}}],
    }


def message_of(good):
    return good["choices"][0]["message"]


def refusal(words, status=400):
    return status, {"error": {"message": words}}


def reasoning(body, good, number):
    """vLLM with a reasoning parser: the whole answer stands where thoughts belong."""
    message_of(good).update(reasoning_content=message_of(good)["content"], content=None)
    return 200, good


def parts(body, good, number):
    text = message_of(good)["content"]
    message_of(good)["content"] = [{"type": "reasoning", "text": "{}"}, {"type": "text", "text": text[:9]}, {"type": "text", "text": text[9:]}]
    return 200, good


def thinks(body, good, number):
    """All tokens are spent on thoughts, unless thinking is turned off."""
    if body.get("chat_template_kwargs") != {"enable_thinking": False}:
        message_of(good).update(reasoning="Let me see. { it could be", content="")
        good["choices"][0]["finish_reason"] = "length"
    return 200, good


def alternate(body, good, number):
    """A chat template that wants turns; the first answer is outside the schema."""
    roles = [m["role"] for m in body["messages"] if m["role"] != "system"]
    if roles != ["user", "assistant"] * (len(roles) // 2) + ["user"]:
        return refusal("Conversation roles must alternate user/assistant/user/assistant/...")
    return (200, chat_reply('{"E": 1}')) if number == 1 else (200, good)


def strict(body, good, number):
    """A reasoning model behind a strict service: no temperature, no max_tokens, no system message."""
    if "temperature" in body:
        return refusal("Unsupported value: 'temperature' does not support 0 with this model.")
    if "max_tokens" in body:
        return refusal("Unsupported parameter: 'max_tokens' is not supported with this model. Use 'max_completion_tokens' instead.")
    if body["messages"][0]["role"] == "system":
        return refusal("System role not supported")
    return 200, good


def qwen(body, good, number):
    """Qwen's compatible mode."""
    wanted = body.get("response_format", {}).get("type", "text")
    if wanted == "json_schema":
        return refusal("'response_format.type' must be one of text, json_object")
    if wanted == "json_object" and "json" not in json.dumps(body["messages"]).lower():
        return refusal("'messages' must contain the word 'json' in some form")
    if body.get("enable_thinking", True):
        return refusal("Json mode response is not supported when enable_thinking is true")
    return 200, good


def ignores_schema(body, good, number):
    """What is not in the text was never read."""
    return 200, good if "JSON Schema" in json.dumps(body["messages"]) else chat_reply('{"material": "foam"}')


CHAT_QUIRKS = {
    "reasoning": reasoning,
    "parts": parts,
    "thinks": thinks,
    "alternate": alternate,
    "strict": strict,
    "qwen": qwen,
    "ignores-schema": ignores_schema,
}


WIDTHS = {"FP16": "e", "FP32": "f", "INT64": "q", "BOOL": "?", "UINT8": "B"}


def numbers_of(data):
    for value in data:
        if isinstance(value, list):
            yield from numbers_of(value)
        else:
            yield value


def pack(tensor):
    """The content of a tensor as bytes, for the binary tensor extension."""
    flat = list(numbers_of(tensor["data"]))
    if tensor["datatype"] == "BYTES":
        return b"".join(struct.pack("<I", len(t)) + t for t in (text.encode() for text in flat))
    nan = [float("nan") if value is None else value for value in flat]
    return struct.pack("<%d%s" % (len(nan), WIDTHS[tensor["datatype"]]), *nan)


def unpack(tensor, data):
    """Pictures become base64, as they come in JSON; everything else what it is."""
    if tensor["datatype"] != "BYTES":
        return list(struct.unpack("<%d%s" % (len(data) // struct.calcsize(WIDTHS[tensor["datatype"]]), WIDTHS[tensor["datatype"]]), data))
    texts = []
    while data:
        (size,) = struct.unpack("<I", data[:4])
        text, data = data[4 : 4 + size], data[4 + size :]
        texts.append(base64.b64encode(text).decode() if text.startswith(b"\x89PNG") else text.decode())
    return texts


def request_of(raw, json_length):
    """The request as it would be in JSON."""
    if json_length is None:
        return json.loads(raw)
    body, rest = json.loads(raw[: int(json_length)]), raw[int(json_length) :]
    for tensor in body["inputs"]:
        size = tensor.get("parameters", {}).get("binary_data_size")
        if size is not None:
            tensor["data"], rest = unpack(tensor, rest[:size]), rest[size:]
    assert not rest
    return body


def without_axis(body):
    """What a model behind a server that batches gets: every tensor of the one entry of the batch."""
    for tensor in body["inputs"]:
        assert tensor["shape"][0] == 1, tensor["shape"]
        tensor["shape"] = tensor["shape"][1:]
    return body


def inference_reply(body):
    images = [base64.b64decode(text, validate=True) for text in body["inputs"][0]["data"]]
    assert images and all(image.startswith(b"\x89PNG") for image in images)
    n = len(images)
    evidence = [[0.6 if label == "Foam" else 0.0 for label in LABELS]] * n
    values = {"E_mean": [-1.0] * n, "E_uncertainty": [0.3] * n, "nu_mean": [None] * n, "nu_uncertainty": [0.04] * n}
    outputs = [{"name": k, "datatype": "FP32", "shape": [n], "data": v} for k, v in values.items()]
    outputs.append({"name": "label_evidence", "datatype": "FP32", "shape": [n, 14], "data": evidence})
    if mode == "shape":
        outputs[-1]["shape"] = [n, 13]
    if mode == "missing-output":
        outputs.pop()
    if mode == "nan":
        outputs[2]["data"] = [float("nan")] * n
    if mode == "negative":
        outputs[1]["data"] = [-1.0] * n
    return {"model_name": "m", "outputs": outputs}


# Where the toy's parts are in every view, in fractions of the picture.
PLACES = {"toy": (0.2, 0.1, 0.8, 0.9), "ball": (0.3, 0.1, 0.7, 0.5), "box": (0.2, 0.5, 0.8, 0.9)}


def size_of(body):
    image = base64.b64decode(body["inputs"][0]["data"][0], validate=True)
    assert image.startswith(b"\x89PNG")
    return struct.unpack(">II", image[16:24])


def detector_reply(body):
    width, height = size_of(body)
    assert body["inputs"][1]["name"] == "prompt" and body["inputs"][1]["shape"] == [1]
    text = body["inputs"][1]["data"][0]
    boxes, scores = [], []
    if text in PLACES:
        x0, y0, x1, y1 = PLACES[text]
        # One box beyond the image, one too weak.
        boxes = [[x0 * width, y0 * height, x1 * width, y1 * height], [-5.0, 0.0, 5.0, 5.0]]
        scores = [0.8, 0.1]
    if mode == "bad-score":
        scores[:1] = [3.0]
    if mode == "bad-box":
        boxes[:1] = [[9, 9, 1, 1]]
    if mode == "nan-boxes":
        boxes[:1] = [[float("nan"), 0.0, 1.0, 1.0]]
    n = len(boxes)
    return {
        "model_name": "grounding-dino",
        "outputs": [
            {"name": "boxes", "datatype": "FP32", "shape": [n, 4], "data": boxes},
            {"name": "scores", "datatype": "FP32", "shape": [n], "data": scores},
            {"name": "phrases", "datatype": "BYTES", "shape": [n], "data": [text] * n},
        ],
    }


def segmenter_reply(body):
    """Every mask is its box."""
    width, height = size_of(body)
    n, masks, corners = body["inputs"][1]["shape"][0], [], body["inputs"][1]["data"]
    for i in range(n):
        x0, y0, x1, y1 = (int(c) for c in corners[4 * i : 4 * i + 4])
        inside = [0] * x0 + [1] * (x1 - x0) + [0] * (width - x1)
        for y in range(height):
            masks += inside if y0 <= y < y1 else [0] * width
    shape = [n, height, width + 1 if mode == "mask-shape" else width]
    return {
        "model_name": "sam2",
        "outputs": [
            {"name": "masks", "datatype": "BOOL", "shape": shape, "data": masks},
            {"name": "scores", "datatype": "FP32", "shape": [n], "data": [0.5] * n},
        ],
    }


TENSORS = {
    "grounding-dino": (["image", "prompt"], ["boxes", "scores", "phrases"]),
    "sam2": (["image", "boxes"], ["masks", "scores"]),
}


def clip_reply(body):
    """Encoders of two numbers: the text lies along x, every frame at a cosine of 0.6 to it."""
    (tensor,) = body["inputs"]
    size = 1
    for extent in tensor["shape"]:
        size *= extent
    assert len(tensor["data"]) == size
    if tensor["name"] == "input_ids":
        assert tensor["datatype"] == "INT64" and tensor["shape"] == [1, 77]
        name, embedding = "text_embeds", [2.0, 0.0]
    else:
        assert tensor["datatype"] == "FP32" and tensor["shape"] == [1, 3, 224, 224]
        name, embedding = "image_embeds", [3.0, 4.0]
    return {"model_name": "clip", "outputs": [{"name": name, "datatype": "FP32", "shape": [1, 2], "data": embedding}]}


def tracker_reply(body):
    """Every query moves by one pixel to the right per frame; the first one is hidden after frame 0."""
    tensors = {t["name"]: t for t in body["inputs"]}
    frames, (_, n, _) = tensors["frames"]["data"], tensors["queries"]["shape"]
    assert all(base64.b64decode(f, validate=True).startswith(b"\x89PNG") for f in frames)
    flat = tensors["queries"]["data"]
    points = [flat[3 * i + 1 : 3 * i + 3] for i in range(n)]
    tracks = [[[x + t, y] for x, y in points] for t in range(len(frames))]
    visibility = [[2.0 if mode == "negative" else float(i > 0 or t == 0) for i in range(n)] for t in range(len(frames))]
    outputs = [
        {"name": "tracks", "datatype": "FP32", "shape": [1, len(frames), n, 2], "data": [tracks]},
        {"name": "visibility", "datatype": "FP32", "shape": [1, len(frames), n], "data": [visibility]},
    ]
    return {"model_name": "tracker", "outputs": outputs}


class Handler(http.server.BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"

    def log_message(self, *_):
        pass

    def reply(self, status, body, content_type="application/json", headers=()):
        data = body if isinstance(body, bytes) else (body if isinstance(body, str) else json.dumps(body)).encode()
        self.send_response(status)
        self.send_header("Content-Type", content_type)
        self.send_header("Content-Length", str(len(data)))
        for name, value in headers:
            self.send_header(name, value)
        self.end_headers()
        self.wfile.write(data)

    def is_loading(self):
        """For the first second after the first request."""
        global loaded_at
        with lock:
            loaded_at = loaded_at or time.monotonic() + 1
        return mode.startswith("loading") and time.monotonic() < loaded_at

    def do_GET(self):
        self.note(None)
        path = self.path.split("?")[0]
        if mode == "gateway" and not self.may_pass():
            return
        if mode == "loading-triton" and (path.endswith("/ready") or "/health" in path):
            return self.reply(400 if self.is_loading() else 200, {"error": "Model version not ready"})
        if mode == "triton-nobody" and path.endswith("/ready"):
            return self.reply(200 if "/health" in path else 400, {"error": "Model version not ready"})
        if mode == "loading-silent" and not path.endswith("/ready"):
            return self.reply(404, {"error": "no such path"})
        if self.is_loading():
            return self.reply(503, {"error": {"code": 503, "message": "Loading model"}})
        if path.endswith("/ready"):
            self.send_response(503 if mode == "not-ready" else 200)
            self.send_header("Content-Length", "0")
            self.end_headers()
        elif path.endswith("/models"):
            if mode == "unauthorised":
                return self.reply(401, {"error": {"message": "no key, no answer"}})
            self.reply(200, {"object": "list", "data": [{"id": "tester", "object": "model", "owned_by": "tests"}]})
        elif path.endswith("/health"):
            self.reply(200, {"status": "ok"})
        elif path.endswith("/v2"):
            self.reply(200, {"name": "tests", "version": "1", "extensions": ["binary_tensor_data"]})
        else:
            inputs, names = TENSORS.get(path.split("/")[-1], (["crops"], OUTPUTS))
            if "/clip-" in path:
                inputs, names = ["pixel_values", "input_ids"], ["image_embeds", "text_embeds"]
            if "/tracker" in path:
                inputs, names = ["frames", "queries"], ["tracks", "visibility"]
            names = names[:-1] if mode == "no-such-output" else names
            if mode == "no-metadata":
                inputs = names = []
            kind = {"image": "BYTES", "prompt": "BYTES", "crops": "BYTES", "frames": "BYTES", "phrases": "BYTES", "input_ids": "INT64"}
            axes = {"boxes": [-1, 4], "masks": [-1, -1, -1], "label_evidence": [-1, 14]}
            half = "FP16" if mode == "fp16" else "FP32"

            def declared(name):
                shape = ([-1] if mode == "batched" else []) + axes.get(name, [-1])
                return {"name": name, "datatype": kind.get(name, half), "shape": shape}

            self.reply(
                200,
                {
                    "name": "m",
                    "platform": "OpenVINO" if mode == "openvino" else "test",
                    "inputs": [declared(i) for i in inputs],
                    "outputs": [declared(o) for o in names],
                },
            )

    def do_POST(self):
        raw, json_length = self.rfile.read(int(self.headers["Content-Length"])), self.headers.get("Inference-Header-Content-Length")
        body = request_of(raw, json_length)
        number = self.note(body)
        path = self.path.split("?")[0]
        if self.is_loading():
            return self.reply(503, {"error": {"code": 503, "message": "Loading model"}})
        if path.endswith("/infer"):
            if mode == "openvino" and json_length is None:
                return self.reply(400, {"error": "BYTES are decoded from binary data only"})
            if mode == "batched":
                body = without_axis(body)
            replies = {"grounding-dino": detector_reply, "sam2": segmenter_reply}
            served = replies.get(path.split("/")[-2], inference_reply)
            if "/clip-" in self.path:
                served = clip_reply
            if "/tracker" in self.path:
                served = tracker_reply
            good = served(body)
            for output in good["outputs"]:
                if mode == "batched":
                    output["shape"] = [1] + output["shape"]
                if mode == "fp16" and output["datatype"] == "FP32":
                    output["datatype"] = "FP16"
            if any("binary_data" in o.get("parameters", {}) for o in body["outputs"]):
                return self.binary_reply(good)
            if mode == "fp16":
                return self.reply(400, {"error": "sending FP16 data via JSON is not supported"})
        else:
            good = chat_reply(json.dumps(answer_to(body)))
        self.answer(mode if only in self.path else "good", number, body, good)

    def answer(self, mode, number, body, good):
        if mode == "timeout":
            time.sleep(5)
        elif mode == "drip":
            # A byte now and then: every single read succeeds, the whole never comes.
            self.send_response(200)
            self.send_header("Content-Type", "application/json")
            self.send_header("Content-Length", "1000")
            self.end_headers()
            try:
                for _ in range(50):
                    self.wfile.write(b" ")
                    self.wfile.flush()
                    time.sleep(0.1)
            except OSError:
                pass
        elif mode == "429" and number == 1:
            self.reply(429, {"error": "slow down"}, headers=[("Retry-After", "1")])
        elif mode == "429-long":
            self.reply(429, {"error": "slow down"}, headers=[("Retry-After", "3600")])
        elif mode == "500-twice" and number <= 2:
            self.reply(500, {"error": "out of memory"})
        elif mode == "500":
            self.reply(500, {"error": "out of memory, said " + self.headers.get("Authorization", "")})
        elif mode == "501":
            self.reply(501, {"error": "no such thing here"})
        elif mode == "408-once" and number == 1:
            self.reply(408, {})
        elif mode == "reset-once" and number == 1:
            self.connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
            self.close_connection = True
            self.connection.close()
        elif mode == "cut":
            self.send_response(200)
            self.send_header("Content-Type", "application/json")
            self.send_header("Content-Length", "100000")
            self.end_headers()
            self.wfile.write(b'{"choices": [')
            self.close_connection = True
        elif mode == "wrong-type":
            self.reply(200, good, "text/plain")
        elif mode == "html":
            self.reply(200, "<html><body>Please log in</body></html>", "text/html; charset=utf-8")
        elif mode == "html-as-json":
            self.reply(200, "<html><body>Please log in</body></html>")
        elif mode == "no-choices":
            self.reply(200, {"result": "ok"})
        elif mode == "truncated-answer":
            good["choices"][0]["finish_reason"] = "length"
            good["choices"][0]["message"]["content"] = good["choices"][0]["message"]["content"][:-20]
            self.reply(200, good)
        elif mode in CHAT_QUIRKS and "messages" in body:
            self.reply(*CHAT_QUIRKS[mode](body, good, number))
        elif mode == "no-projector":
            self.reply(500, {"error": {"code": 500, "message": "image input is not supported - hint: provide the mmproj", "type": "server_error"}})
        elif mode == "error-200":
            self.reply(200, {"error": {"message": "the engine is dead"}})
        elif mode == "gateway":
            self.gateway(good)
        elif mode == "slow":
            time.sleep(1.5)
            self.reply(200, good)
        elif mode in ("echo-tenant", "echo-header-key"):
            name = "X-Tenant" if mode == "echo-tenant" else "X-Api-Key"
            self.reply(200, {"you are": self.headers.get(name, ""), **good})
        elif mode == "refuse-tenant":
            self.reply(403, {"error": "no tenant " + self.headers.get("X-Tenant", "") + ", no key " + self.headers.get("X-Api-Key", "")})
        elif mode == "outside" or (mode == "outside-once" and number == 1):
            answer = answer_to(body)
            answer["E"] = 1e5  # constitutive parameters are not the model's to set
            self.reply(200, chat_reply(json.dumps(answer)))
        elif mode == "other-row":
            answer = answer_to(body)
            answer["key"] = "cake/candle"
            self.reply(200, chat_reply(json.dumps(answer)))
        elif mode == "prose":
            text = "<think>{ hmm }</think>Here you are:\n```json\n" + json.dumps(answer_to(body)) + "\n```"
            self.reply(200, chat_reply(text))
        elif mode == "no-schema" and "response_format" in body:
            self.reply(400, {"error": "response_format is not supported"})
        elif mode == "huge":
            self.send_response(200)
            self.send_header("Content-Type", "application/json")
            self.send_header("Content-Length", str(100 << 20))
            self.end_headers()
            self.pour(100)
        elif mode == "huge-chunked":
            self.send_response(200)
            self.send_header("Content-Type", "application/json")
            self.send_header("Connection", "close")
            self.end_headers()
            self.pour(100)
        elif mode == "redirect":
            self.reply(307, "", headers=[("Location", "http://example.invalid/v1/chat/completions")])
        elif mode == "redirect-port":
            self.reply(307, "", headers=[("Location", "http://127.0.0.1:9/v1/chat/completions")])
        elif mode == "redirect-get":
            self.reply(302, "", headers=[("Location", self.path + "/here")])
        elif mode == "redirect-same" and not self.path.endswith("/here"):
            self.reply(308, "", headers=[("Location", self.path + "/here")])
        elif mode == "redirect-loop":
            self.reply(307, "", headers=[("Location", self.path)])
        elif mode == "unauthorised":
            self.reply(401, {"error": "key " + self.headers.get("Authorization", "none") + " is not valid"})
        elif mode in ("key-in-type", "key-in-redirect", "key-in-capitals", "key-in-escapes", "key-in-broken-json"):
            key = self.headers.get("Authorization", "").replace("Bearer ", "")
            escaped = "".join("\\u%04X" % ord(c) for c in key)
            if mode == "key-in-type":
                self.reply(200, good, "application/%s+json" % key)
            elif mode == "key-in-redirect":
                self.reply(307, "", headers=[("Location", "http://%s.invalid/v1" % key)])
            elif mode == "key-in-capitals":
                self.reply(403, {"error": "x" * 150 + key.upper() + " is not valid, nor is " + escaped})
            elif mode == "key-in-escapes":
                self.reply(200, '{"you sent": "%s", %s' % (escaped, json.dumps(good)[1:]))
            else:
                self.reply(200, '{"%s": 1, "%s": 2' % (escaped, escaped))
        elif mode == "echo":
            self.reply(200, {"you sent": self.headers.get("Authorization", ""), **good})
        else:
            self.reply(200, good)

    def binary_reply(self, good):
        content = b""
        for output in good["outputs"]:
            data = pack(output)
            del output["data"]
            output["parameters"] = {"binary_data_size": len(data)}
            content += data
        head = json.dumps(good).encode()
        length = str(len(head) + (10**9 if mode == "binary-length" else 0))
        self.reply(200, head + content, "application/octet-stream", [("Inference-Header-Content-Length", length)])

    def may_pass(self):
        """A gateway in front: an address with a query, a host of its own, a key under another name, an organisation."""
        if "?api-version=2024-10-21" not in self.path or self.headers.get("Host") != "models.example":
            self.reply(404, {"error": {"message": "Resource not found"}})
        elif self.headers.get("api-key") != "pmkey-0123456789" or self.headers.get("Authorization"):
            self.reply(401, {"error": {"message": "Access denied"}})
        else:
            return True
        return False

    def gateway(self, good):
        if self.may_pass():
            self.reply(200, good)

    def pour(self, megabytes):
        """Counts in the log how much the client took."""
        taken = 0
        try:
            for _ in range(megabytes):
                self.wfile.write(b" " * (1 << 20))
                taken += 1
        except OSError:
            pass
        self.close_connection = True
        with open(log_file, "a") as log:
            log.write(json.dumps({"megabytes": taken}) + "\n")

    def note(self, body):
        """Writes the request into the log; the number of POST requests so far."""
        global count, posts
        with lock:
            count += 1
            posts += body is not None
            number = posts
        entry = {"path": self.path, "authorization": self.headers.get("Authorization"), "number": count}
        if body is not None and "messages" in body:
            content = [m["content"] for m in body["messages"] if m["role"] == "user"][0]
            images = [p["image_url"]["url"][:22] for p in content if p["type"] == "image_url"]
            entry.update(
                model=body["model"],
                temperature=body.get("temperature"),
                image=images[0] if images else None,
                structured=body.get("response_format", {}).get("type", False),
                messages=len(body["messages"]),
                fields=sorted(body),
            )
        if body is not None and "inputs" in body:
            entry.update(binary="Inference-Header-Content-Length" in self.headers, types=[t["datatype"] for t in body["inputs"]])
        with open(log_file, "a") as log:
            log.write(json.dumps(entry) + "\n")
        return number


class Server(http.server.ThreadingHTTPServer):
    daemon_threads = True

    def handle_error(self, *_):
        pass  # clients that hang up are what the tests are about


server = Server(("127.0.0.1", 0), Handler)
threading.Thread(target=server.serve_forever, daemon=True).start()
with open(port_file + ".new", "w") as f:
    f.write(str(server.server_address[1]))
os.rename(port_file + ".new", port_file)
threading.Timer(60, lambda: os._exit(0)).start()
sys.stdin.read()
os._exit(0)
