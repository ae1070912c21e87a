# Manypass without a GPU: Mesa's software Vulkan draws. Usage: docker run --rm -v "$PWD:/data" IMAGE render model.glb -o still.png
FROM rust:1-slim-bookworm AS build
WORKDIR /src
COPY . .
RUN cargo build --release --locked -p manypass-cli

FROM debian:bookworm-slim
RUN apt-get update \
    && apt-get install -y --no-install-recommends mesa-vulkan-drivers libvulkan1 \
    && rm -rf /var/lib/apt/lists/*
COPY --from=build /src/target/release/manypass /usr/local/bin/manypass
WORKDIR /data
ENTRYPOINT ["manypass"]
